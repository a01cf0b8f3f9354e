// Appended to the kernels that compare pixels: a blend of the absolute difference of the values and the number of bits of the
// census strings that differ.
fn pixel_costs(left: Pixel, right: Window) -> vec4<u32> {
    let bits = differing_bits(left, right);
    let value = differences(vec4(left[PLANES - 1u]), right[PLANES - 1u]);
    return vec4(blend(value.x, bits.x), blend(value.y, bits.y), blend(value.z, bits.z), blend(value.w, bits.w));
}

fn blend(value: u32, bits: u32) -> u32 {
    let weighted = AD_WEIGHT * unpack(value) + CENSUS_WEIGHT * unpack(bits) + vec4(8u);
    return pack(min(weighted >> vec4(4u), vec4(255u)));
}
