// Appended to the kernels that choose a winner: the part of a pixel by which it is refined.
// Reference: src/reference/winner.rs

// a / b, at most 31, bit by bit. A CPU has no division of many numbers at once, and a float one would not be exact on
// every device.
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

// What half the difference of the neighbours' costs is divided by, for the refinement in pixels: the curvature of a
// parabola, the slope of two lines.
fn divisor(before: u32, here: u32, after: u32) -> u32 {
    if SUBPIXEL == SUBPIXEL_EQUIANGULAR {
        return max(before, after) - here;
    }
    return before + after - 2u * here;
}

// The refinement in 1/16 px of a winner that costs `here`, from the costs of its neighbours; before > here <= after.
fn refinement(before: u32, here: u32, after: u32) -> i32 {
    let k = divisor(before, here, after);
    // 16 (before - after) >= -16 k: shifted by 8 whole steps the quotient is of positive numbers, and at most 16.
    return quotient(16u * (before + k) - 16u * after + k - 1u, 2u * k) - 8;
}
