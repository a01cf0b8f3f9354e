// Appended to the kernels that walk a path: P2 of the step into a pixel, from the words that `penalties` left, laid line by
// line into a texture WORDS wide. A direction that goes up or to the left finds its step at the pixel before.
@group(0) @binding(PENALTIES) var penalties: texture_storage_2d<r32uint, read>;

fn penalty(x: i32, y: i32) -> u32 {
    let stride = i32((frame.width + 15u) / 16u) * 16;
    // Where a path starts that pixel may lie outside, and the penalty does not matter.
    let at = u32(clamp(y * stride + x + pass_.penalty_offset, 0, i32(frame.height) * stride - 1));
    return extractBits(textureLoad(penalties, vec2(at % WORDS, at / WORDS)).x, pass_.penalty_shift, 8u);
}
