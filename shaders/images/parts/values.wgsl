// Appended to the kernels that read single values of images laid out like a gray one, with 16 columns before the first.
fn place_of(x: u32, y: u32, stride: u32) -> vec2<u32> {
    let index = y * stride + (x + 16u) / 16u;
    return vec2(index % TEXELS, index / TEXELS);
}

fn value_of(texel: vec4<u32>, x: u32) -> u32 {
    return extractBits(texel[(x & 15u) >> 2u], (x & 3u) * 8u, 8u);
}
