// Appended to the kernels that compare pixels: the number of bits of the census strings that differ.
fn pixel_costs(left: Pixel, right: Window) -> vec4<u32> {
    return differing_bits(left, right);
}
