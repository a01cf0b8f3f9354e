// Appended to `intake` where Y is a place in a buffer, dispatch.stride words a row, and U and V, a pair for two columns and two
// rows, are another one, dispatch.own.chroma_stride words a row.
@group(0) @binding(3) var<storage, read> luma: array<u32>;
@group(0) @binding(4) var<storage, read> chroma: array<u32>;

fn luma_at(at: vec2<u32>) -> u32 {
    return extractBits(luma[at.y * dispatch.stride + at.x / 4u], (at.x & 3u) * 8u, 8u);
}

fn chroma_at(at: vec2<u32>) -> vec2<u32> {
    let four = unpack(chroma[at.y / 2u * dispatch.own.chroma_stride + at.x / 4u]);
    return select(four.xy, four.zw, vec2((at.x & 2u) == 2u));
}
