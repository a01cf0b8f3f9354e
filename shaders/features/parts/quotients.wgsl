// Appended to the kernels that divide: floor(n / d) for n < 2^22 and d < 2^16. The float's quotient is off by at most one, which
// integers correct.
fn quotients(n: vec4<u32>, d: vec4<u32>) -> vec4<u32> {
    let estimate = vec4<u32>(vec4<f32>(n) / vec4<f32>(d));
    let rest = bitcast<vec4<i32>>(n - estimate * d);
    let low = select(estimate, estimate + vec4(1u), rest >= bitcast<vec4<i32>>(d));
    return select(low, estimate - vec4(1u), rest < vec4(0));
}
