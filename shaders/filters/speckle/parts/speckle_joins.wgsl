// Appended to the kernels of the stage speckle. A pixel's number is its place in the map, rows padded to a multiple of eight.
// Reference: src/reference/filters/speckle.rs

// Valid and no farther apart than the neighbours of a region may be.
fn joined(a: vec4<i32>, b: vec4<i32>) -> vec4<bool> {
    let near = abs(a - b) <= vec4(frame.speckle_range);
    return near & (a != vec4(INVALID)) & (b != vec4(INVALID));
}

// The pixels that are joined to the one before them in the row.
fn joined_along(p: Octet) -> u32 {
    return mask(joined(p.even, vec4(p.before, p.odd.xyz)), joined(p.odd, p.even));
}

// The valid pixels that are not, counting the first of eight as one.
fn run_starts(p: Octet, along: u32) -> u32 {
    return mask(p.even != vec4(INVALID), p.odd != vec4(INVALID)) & ~(along & 0xfeu);
}

// The pixels of a row that are joined to those of the next one, without those whose neighbour before says the same.
fn joined_down(row: u32, i: u32) -> u32 {
    let p = octet(row, i);
    let q = octet(row + 1u, i);
    let down = mask(joined(p.even, q.even), joined(p.odd, q.odd));
    let before = select(0u, 1u, joined(vec4(p.before), vec4(q.before)).x);
    return down & ~(((down << 1u) | before) & joined_along(p) & joined_along(q));
}
