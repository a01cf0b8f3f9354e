// Appended to the kernels that make costs of block sums: four costs in a word.
fn quantised(sums: vec4<u32>) -> u32 {
    return pack((sums * frame.cost_scale + vec4(1u << 23u)) >> vec4(24u));
}
