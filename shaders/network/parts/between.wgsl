// Appended to the kernels that interpolate: where value `to` of `count` lies between `others`. With `corners` the first and the
// last values of both lie on each other, else their outer borders do.

struct Between {
    low: u32,
    high: u32,
    part: f32,   // of the way from low to high
}

fn between(to: u32, count: u32, others: u32, corners: bool) -> Between {
    // The place in parts of `unit`.
    var unit = 2u * count;
    var place = max((2u * to + 1u) * others, count) - count;
    if corners {
        unit = max(count, 2u) - 1u;
        place = to * (others - 1u);
    }
    let low = min(place / unit, others - 1u);
    return Between(low, min(low + 1u, others - 1u), f32(place % unit) / f32(unit));
}
