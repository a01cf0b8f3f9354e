// Appended to the kernels that compute roots: floor(sqrt(n)) for n < 2^31. The float root is off by at most one, which
// integers correct.
fn integer_root(n: u32) -> u32 {
    var root = u32(sqrt(f32(n)));
    if root * root > n {
        root -= 1u;
    }
    if (root + 1u) * (root + 1u) <= n {
        root += 1u;
    }
    return root;
}
