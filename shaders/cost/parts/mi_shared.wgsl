// Appended to the kernels that need the mutual information of a left value and four right ones, lg P(l, r) - lg P(l) -
// lg P(r), from the smoothed logarithms of both tables.
fn shared_by(l: u32, four: u32, logarithms: vec4<u32>) -> vec4<i32> {
    let left = (marginals[l / 4u][l % 4u] + 32u) >> 6u;
    let right = (marginals[64u + four] + vec4(32u)) >> vec4(6u);
    return vec4<i32>((logarithms + vec4(2048u)) >> vec4(12u)) - vec4(i32(left)) - vec4<i32>(right);
}
