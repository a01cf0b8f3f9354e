// Appended to the kernels that send messages: the smoothness is half where the gray image has an edge. For the neighbours above,
// below, to the left and to the right: bits by which the weight and the truncation are shifted.
@group(0) @binding(6) var gray: texture_storage_2d<rgba32uint, read>;

fn gray_at(x: u32, y: u32) -> i32 {
    let texel = y * frame.gray_stride + 1u + x / 16u;
    let words = textureLoad(gray, vec2(texel % TEXELS, texel / TEXELS));
    return i32(extractBits(words[(x >> 2u) & 3u], 8u * (x & 3u), 8u));
}

fn edges_at(x: u32, y: u32) -> vec4<u32> {
    let around = vec4(
        gray_at(x, max(y, 1u) - 1u),
        gray_at(x, min(y + 1u, frame.height - 1u)),
        gray_at(max(x, 1u) - 1u, y),
        gray_at(min(x + 1u, frame.width - 1u), y));
    return select(vec4(0u), vec4(1u), abs(around - vec4(gray_at(x, y))) >= vec4(SMOOTHNESS_EDGE));
}
