// Appended to the kernels that refine a winner: a / b, at most 31, bit by bit. A CPU has no division of many numbers at
// once, and a float one would not be exact on every device.
fn quotient(a: u32, b: u32) -> i32 {
    var rest = a;
    var bits = 0u;
    for (var i = 0u; i < 5u; i++) {
        let part = b << (4u - i);
        let fits = rest >= part;
        rest -= select(0u, part, fits);
        bits = 2u * bits + select(0u, 1u, fits);
    }
    return i32(bits);
}
