// Appended to the kernels that compare pixels: twice the number of bits of the census strings that differ, and the absolute
// differences of both derivatives.
fn pixel_costs(left: Pixel, right: Window) -> vec4<u32> {
    return 2u * differing_bits(left, right)
        + differences(vec4(left[min(CENSUS_PLANES, PLANES - 1u)]), right[min(CENSUS_PLANES, PLANES - 1u)])
        + differences(vec4(left[PLANES - 1u]), right[PLANES - 1u]);
}
