// Appended to the kernels that choose a winner: the part of a pixel by which it is refined, its margin over its rival.
// Reference: src/reference/winner/winner.rs

// a / b, below 2^digits, bit by bit. A CPU has no vector instruction that divides integers, and a float one would not be exact on
// every device.
fn quotient(a: u32, b: u32, digits: u32) -> u32 {
    var rest = a;
    var bits = 0u;
    for (var i = 0u; i < digits; i++) {
        let part = b << ((digits - 1u - i) & 31u);
        let fits = rest >= part;
        rest -= select(0u, part, fits);
        bits = 2u * bits + select(0u, 1u, fits);
    }
    return bits;
}

// The share of its cost, 0 to 255, by which a rival costs more than the winner, which costs `here`.
fn margin_over(here: u32, rival: u32) -> u32 {
    return select(0u, quotient(255u * (rival - here), rival, 8u), rival > 0u);
}

// What half the difference of the neighbours' costs is divided by, for the refinement in pixels: the curvature of a
// parabola, the slope of two lines.
fn divisor(before: u32, here: u32, after: u32) -> u32 {
    if SUBPIXEL == SUBPIXEL_EQUIANGULAR {
        return max(before, after) - here;
    }
    return before + after - 2u * here;
}

// The largest cost of a rival that fails the uniqueness test rival * (100 - UNIQUENESS) > here * 100.
fn largest_rival(here: u32) -> u32 {
    if STEREO_BM == 1u {
        return here + here * UNIQUENESS / 100u;
    }
    if OPENCV_RULES == 1u {
        return (max(here * 100u, 1u) - 1u) / (100u - UNIQUENESS); // equality does not fail; see `winner` for a cost of 0
    }
    return here * 100u / (100u - UNIQUENESS);
}

// The refinement in 1/16 px of a winner that costs `here`, from the costs of its neighbours; before > here <= after,
// by the rules of StereoBM before >= here < after.
fn refinement(before: u32, here: u32, after: u32) -> i32 {
    if STEREO_BM == 1u {
        // 128 (before - after) / k in 1/256 px, towards zero, then to 1/16 px, upwards.
        let part = quotient(128u * max(before - min(before, after), after - min(before, after)),
            max(max(before, after) - here, 1u), 8u);
        return select(-i32(part >> 4u), i32((part + 15u) >> 4u), before > after);
    }
    if OPENCV_RULES == 1u {
        // (16 (before - after) + k) / (2 k), towards zero, with the k of a parabola.
        let k = max(before + after - 2u * here, 1u);
        let forward = 16u * before + k >= 16u * after;
        let size = select(16u * after - 16u * before - k, 16u * before + k - 16u * after, forward);
        return select(-1, 1, forward) * i32(quotient(size, 2u * k, 5u));
    }
    let k = divisor(before, here, after);
    // 16 (before - after) >= -16 k: shifted by 8 whole steps the quotient is of positive numbers, and at most 16.
    return i32(quotient(16u * (before + k) - 16u * after + k - 1u, 2u * k, 5u)) - 8;
}
