// Appended to the kernels that compare pixels: (l - r)^2, as 16-bit halves in the order of `columns`.
fn pixel_pairs(left: Pixel, right: Window) -> array<vec4<u32>, 2> {
    let difference = differences(vec4(left[0]), right[0]);
    return array(squares(low_pairs(difference)), squares(high_pairs(difference)));
}

fn squares(pairs: vec4<u32>) -> vec4<u32> {
    let low = pairs & vec4(0xffu);
    let high = pairs >> vec4(16u);
    return (low * low) | ((high * high) << vec4(16u));
}
