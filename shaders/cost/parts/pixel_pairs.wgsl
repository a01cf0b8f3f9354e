// Appended to the kernels that sum columns: pixel costs of a byte as 16-bit halves in the order of `columns`.
fn pixel_pairs(left: Pixel, right: Window) -> array<vec4<u32>, 2> {
    let costs = pixel_costs(left, right);
    return array(low_pairs(costs), high_pairs(costs));
}
