// Appended to the kernels that compare pixels: l * r, as 16-bit halves in the order of `columns`.
fn pixel_pairs(left: Pixel, right: Window) -> array<vec4<u32>, 2> {
    let value = left[0] & 0xffu;
    return array(value * low_pairs(right[0]), value * high_pairs(right[0]));
}
