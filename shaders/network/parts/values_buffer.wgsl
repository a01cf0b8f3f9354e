// Appended to the kernels that read values of the network: vectors of four channels each in a buffer, block by block,
// [block of channels][plane][row][column]. The planes of an image are the two sides.
@group(0) @binding(2) var<storage, read> values: array<vec4<f32>>;

fn value_at(at: u32) -> vec4<f32> {
    return values[at];
}
