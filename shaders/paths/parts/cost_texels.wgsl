// Appended to the kernels that read the cost: its 16-byte words, laid line by line into a texture TEXELS wide.
@group(0) @binding(2) var cost: texture_storage_2d<rgba32uint, read>;

fn costs_at(slice: u32) -> Slice {
    var costs: Slice;
    for (var w = 0u; w < WIDTH; w++) {
        let texel = slice * WIDTH + w;
        costs[w] = textureLoad(cost, vec2(texel % TEXELS, texel / TEXELS));
    }
    return costs;
}
