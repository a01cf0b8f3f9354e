// conv3d_half: a 3x3x3 convolution of a volume with stride 2.
// values (f32, [block of 4 channels][plane][row][column][channel]) -> result, laid out alike
// One invocation: four channels of six columns.
// Border: zeros beyond the input.
// With: convolution, layer, line_own, common
// Chosen: values*, weights*, taps*
// Reference: src/reference/network/convolutions.rs

const DEPTH: u32 = 3u;
const SIDE: u32 = 3u;
const STRIDE: u32 = 2u;
const DILATION: u32 = 1u;

@group(0) @binding(5) var<storage, read_write> result: array<vec4<f32>>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    convolve(task_of(id), local % 8u);
}
