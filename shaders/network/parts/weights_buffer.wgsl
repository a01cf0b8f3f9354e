// Appended to the convolutions: the weights of the whole network, and the values that are added; laid out as the values that are
// read. The weights of an operation: the bias of each block of four outputs, then of each of them
// [block of inputs][plane][row][column][input] of the neighbourhood, four outputs a vector.
@group(0) @binding(3) var<storage, read> weights: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> added: array<vec4<f32>>;

fn weight_at(at: u32) -> vec4<f32> {
    return weights[at];
}

fn added_at(at: u32) -> vec4<f32> {
    return added[at];
}
