// Appended to `intake` where a word of the buffer is Y, U, Y and V of two columns, dispatch.stride words a row.
@group(0) @binding(3) var<storage, read> image: array<u32>;

fn two_columns(at: vec2<u32>) -> vec4<u32> {
    return unpack(image[at.y * dispatch.stride + at.x / 2u]);
}

fn luma_at(at: vec2<u32>) -> u32 {
    let four = two_columns(at);
    return select(four.x, four.z, (at.x & 1u) == 1u);
}

fn chroma_at(at: vec2<u32>) -> vec2<u32> {
    return two_columns(at).yw;
}
