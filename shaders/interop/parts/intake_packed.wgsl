// Appended to `intake` where a texel of the texture is Y, U, Y and V of two columns.
@group(0) @binding(3) var image: texture_2d<f32>;

fn two_columns(at: vec2<u32>) -> vec4<u32> {
    return vec4<u32>(textureLoad(image, vec2(at.x / 2u, at.y), 0) * 255.0 + vec4(0.5));
}

fn luma_at(at: vec2<u32>) -> u32 {
    let four = two_columns(at);
    return select(four.x, four.z, (at.x & 1u) == 1u);
}

fn chroma_at(at: vec2<u32>) -> vec2<u32> {
    return two_columns(at).yw;
}
