// Appended to the kernels that read the cost: its 16-byte words, laid line by line into a texture TEXELS wide.
fn cost_at(index: u32) -> vec4<u32> {
    return textureLoad(cost, vec2(index % TEXELS, index / TEXELS));
}
