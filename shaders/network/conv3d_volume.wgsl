// conv3d_volume: a 3x3x3 convolution of the volume of the features of both sides, which is never stored: plane i has the left
//   features, then the right ones at column x - i; where x < i all channels are 0.
// values (f32, [block of 4 channels][side][row][column][channel]) -> result (f32, [block of 4 channels][plane][row][column][channel])
// One invocation: four channels of six columns.
// Border: zeros beyond the volume.
// With: convolution, layer, common
// Chosen: values*, weights*, taps*
// Reference: src/reference/network/convolutions.rs

const DEPTH: u32 = 3u;
const SIDE: u32 = 3u;
const STRIDE: u32 = 1u;
const DILATION: u32 = 1u;

@group(0) @binding(5) var<storage, read_write> result: array<vec4<f32>>;

// Half of the blocks are of the left side.
fn place_of(block: u32, z: u32, y: u32) -> u32 {
    let half = dispatch.own.blocks / 2u;
    let right = block >= half;
    let line = (select(0u, dispatch.own.in_rows, right) + y) * dispatch.own.in_columns;
    return dispatch.own.at + (block % half) * dispatch.own.in_stride + line - select(0u, z, right);
}

fn reaches(x: u32, z: u32) -> bool {
    return x < dispatch.own.in_columns && x >= z;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    convolve(task_of(id), local % 8u);
}
