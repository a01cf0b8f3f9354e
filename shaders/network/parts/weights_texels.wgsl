// Appended to the convolutions: the weights of the whole network, and the values that are added; laid out as the values that are
// read. The weights of an operation: the bias of each block of four outputs, then of each of them
// [block of inputs][plane][row][column][input] of the neighbourhood, four outputs a texel.
@group(0) @binding(3) var weights: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(4) var added: texture_storage_2d<rgba32uint, read>;

fn weight_at(at: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(textureLoad(weights, vec2(at % TEXELS, at / TEXELS)));
}

fn added_at(at: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(textureLoad(added, vec2(at % TEXELS, at / TEXELS)));
}
