// Appended to the kernels that read the cost: its 16-byte words, laid line by line into a texture COST_TEXELS wide.
fn cost_at(index: u32) -> vec4<u32> {
    return textureLoad(cost, vec2(index % COST_TEXELS, index / COST_TEXELS));
}
