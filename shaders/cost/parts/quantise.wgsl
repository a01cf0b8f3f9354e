// Appended to the kernels that make costs of block sums: four costs in a word.
//
// No cost is above 89, so the minimum changes nothing. It keeps LLVM from moving the arithmetic before it into
// lavapipe's store, which is a loop over the lanes (docs/PERFORMANCE.md).
fn quantised(sums: vec4<u32>) -> u32 {
    return min(pack(((sums >> vec4(NARROWING)) * frame.cost_scale + vec4(1u << 23u)) >> vec4(24u)), 0x59595959u);
}

// Sixteen costs, of bytes. Where the scale is a power of two, a shift of the bytes does it.
fn quantised_bytes(sums: vec4<u32>) -> vec4<u32> {
    if SCALE_SHIFT == 0u {
        return quantised_block(low_pairs(sums), high_pairs(sums));
    }
    let rounded = sums + vec4(0x01010101u << (max(SCALE_SHIFT, 1u) - 1u));
    return min((rounded >> vec4(SCALE_SHIFT)) & vec4((255u >> SCALE_SHIFT) * 0x01010101u), vec4(0x59595959u));
}

// Sixteen costs, of sums in 16-bit halves.
fn quantised_block(low: vec4<u32>, high: vec4<u32>) -> vec4<u32> {
    return vec4(quantised(unpack_pairs(low.x, low.y)), quantised(unpack_pairs(low.z, low.w)),
        quantised(unpack_pairs(high.x, high.y)), quantised(unpack_pairs(high.z, high.w)));
}
