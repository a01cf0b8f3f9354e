// Appended to the kernels that keep the right pixels which disparities are compared with: bytes of the right planes.
fn right_word(word: u32, row: u32) -> u32 {
    return textureLoad(right, vec2(min(word, frame.right_stride - 1u), row)).x;
}

// Sixteen bytes of a row of the right planes, from byte j on.
fn window(j: u32, row: u32) -> vec4<u32> {
    let at = j >> 2u;
    let shift = (j & 3u) * 8u;
    let words = vec4(right_word(at, row), right_word(at + 1u, row), right_word(at + 2u, row), right_word(at + 3u, row));
    let next = vec4(words.yzw, right_word(at + 4u, row));
    return (words >> vec4(shift)) | ((next << vec4(1u)) << vec4(31u - shift));
}

// Four bytes of a row of the right planes, from byte j - 3 to byte j. Those before byte 0 are arbitrary.
fn entering_bytes(j: u32, row: u32) -> u32 {
    let shift = (j & 3u) * 8u;
    let before = right_word(max(j >> 2u, 1u) - 1u, row);
    return (right_word(j >> 2u, row) << (24u - shift)) | ((before >> 8u) >> shift);
}
