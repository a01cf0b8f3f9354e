// Appended to the kernels that read a map eight pixels, an octet, at a time. Its even and odd columns are apart, as the
// halves of words are; bit j of a mask is about pixel j.

@group(0) @binding(2) var map: texture_storage_2d<rgba32uint, read>;

struct Octet {
    even: vec4<i32>,
    odd: vec4<i32>,
    before: i32,
}

fn map_at(index: u32) -> vec4<u32> {
    return textureLoad(map, vec2(index % TEXELS, index / TEXELS));
}

// The columns x, x + 2, x + 4 and x + 6 of the four words from column x on.
fn even_values(words: vec4<u32>) -> vec4<i32> {
    return bitcast<vec4<i32>>(words << vec4(16u)) >> vec4(16u);
}

// The columns x + 1, x + 3, x + 5 and x + 7.
fn odd_values(words: vec4<u32>) -> vec4<i32> {
    return bitcast<vec4<i32>>(words) >> vec4(16u);
}

fn pack_octet(even: vec4<i32>, odd: vec4<i32>) -> vec4<u32> {
    return (bitcast<vec4<u32>>(even) & vec4(0xffffu)) | (bitcast<vec4<u32>>(odd) << vec4(16u));
}

// The pixels of a row from column 8 i on, and the one before; those outside the image are invalid.
fn octet(row: u32, i: u32) -> Octet {
    let at = row * (frame.map_stride / 4u) + i;
    let words = map_at(at);
    let inside = i32(frame.width) - i32(8u * i);
    return Octet(
        select(vec4(INVALID), even_values(words), vec4(0, 2, 4, 6) < vec4(inside)),
        select(vec4(INVALID), odd_values(words), vec4(1, 3, 5, 7) < vec4(inside)),
        select(map_value(map_at(max(at, 1u) - 1u).w, 1u), INVALID, i == 0u));
}

fn mask(even: vec4<bool>, odd: vec4<bool>) -> u32 {
    let bits = select(vec4(0u), vec4(1u, 4u, 16u, 64u), even) | select(vec4(0u), vec4(2u, 8u, 32u, 128u), odd);
    return bits.x | bits.y | bits.z | bits.w;
}
