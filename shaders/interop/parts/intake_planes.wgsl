// Appended to `intake` where Y is one texture, or a plane of one, and U and V are another of half the sides.
@group(0) @binding(3) var luma: texture_2d<f32>;
@group(0) @binding(4) var chroma: texture_2d<f32>;

fn luma_at(at: vec2<u32>) -> u32 {
    return u32(textureLoad(luma, at, 0).x * 255.0 + 0.5);
}

fn chroma_at(at: vec2<u32>) -> vec2<u32> {
    return vec2<u32>(textureLoad(chroma, at / vec2(2u), 0).xy * 255.0 + vec2(0.5));
}
