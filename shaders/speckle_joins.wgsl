// Appended to the kernels of the stage speckle. A map is read eight pixels at a time. A pixel's number is its place in the
// map, rows padded to a multiple of eight; bit j of a mask is about pixel j of eight.
// Reference: src/reference/speckle.rs

@group(0) @binding(2) var map: texture_storage_2d<rgba32uint, read>;

struct Eight {
    even: vec4<i32>,
    odd: vec4<i32>,
    before: i32,
}

fn map_at(index: u32) -> vec4<u32> {
    return textureLoad(map, vec2(index % TEXELS, index / TEXELS));
}

// The pixels of a row from column 8 i on, and the one before; those outside the image are invalid.
fn eight(row: u32, i: u32) -> Eight {
    let at = row * (frame.map_stride / 4u) + i;
    let words = bitcast<vec4<i32>>(map_at(at));
    let inside = i32(frame.width) - i32(8u * i);
    return Eight(
        select(vec4(INVALID), (words << vec4(16u)) >> vec4(16u), vec4(0, 2, 4, 6) < vec4(inside)),
        select(vec4(INVALID), words >> vec4(16u), vec4(1, 3, 5, 7) < vec4(inside)),
        select(map_value(map_at(max(at, 1u) - 1u).w, 1u), INVALID, i == 0u));
}

// Valid and no farther apart than the neighbours of a region may be.
fn joined(a: vec4<i32>, b: vec4<i32>) -> vec4<bool> {
    let near = abs(a - b) <= vec4(frame.speckle_range);
    return near & (a != vec4(INVALID)) & (b != vec4(INVALID));
}

fn mask(even: vec4<bool>, odd: vec4<bool>) -> u32 {
    let bits = select(vec4(0u), vec4(1u, 4u, 16u, 64u), even) | select(vec4(0u), vec4(2u, 8u, 32u, 128u), odd);
    return bits.x | bits.y | bits.z | bits.w;
}

// The pixels that are joined to the one before them in the row.
fn joined_along(p: Eight) -> u32 {
    return mask(joined(p.even, vec4(p.before, p.odd.xyz)), joined(p.odd, p.even));
}

// The valid pixels that are not, counting the first of eight as one.
fn run_starts(p: Eight, along: u32) -> u32 {
    return mask(p.even != vec4(INVALID), p.odd != vec4(INVALID)) & ~(along & 0xfeu);
}

// The pixels of a row that are joined to those of the next one, without those whose neighbour before says the same.
fn joined_down(row: u32, i: u32) -> u32 {
    let p = eight(row, i);
    let q = eight(row + 1u, i);
    let down = mask(joined(p.even, q.even), joined(p.odd, q.odd));
    let before = select(0u, 1u, joined(vec4(p.before), vec4(q.before)).x);
    return down & ~(((down << 1u) | before) & joined_along(p) & joined_along(q));
}
