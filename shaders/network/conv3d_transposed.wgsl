// conv3d_transposed: a transposed 3x3x3 convolution of a volume with stride 2, to twice its sides: value i of the input, times
//   tap k, is added to value 2i + k - 1 of the output, along each axis. So an even output is tap 1 of one value, an odd one
//   tap 2 of one and tap 0 of the next.
// values (f32, [block of 4 channels][plane][row][column][channel]) -> result, laid out alike
// One invocation: four channels of six columns.
// Border: zeros beyond the input.
// With: layer, line_own, common
// Chosen: values*, weights*
// Reference: src/reference/network/convolutions.rs

const HALF: u32 = COLUMNS / 2u;

@group(0) @binding(5) var<storage, read_write> result: array<vec4<f32>>;

// Adds the four channels of a value, times the weights of a tap.
fn times(at: u32, value: vec4<f32>, sum: vec4<f32>) -> vec4<f32> {
    let a = fma(weight_at(at), vec4(value.x), sum);
    let b = fma(weight_at(at + 1u), vec4(value.y), a);
    return fma(weight_at(at + 3u), vec4(value.w), fma(weight_at(at + 2u), vec4(value.z), b));
}

// What is added to even and odd columns of the output by a line of the input, of which the column of the first is `x`.
fn add_line(place: u32, x: u32, z: u32, at: u32, sums: ptr<function, array<vec4<f32>, COLUMNS>>) {
    var line = array<vec4<f32>, HALF + 1u>();
    for (var i = 0u; i < HALF + 1u; i++) {
        let inside = reaches(x + i, z);
        line[i] = select(vec4(0.0), value_at(select(0u, place + x + i, inside)), inside);
    }
    for (var i = 0u; i < HALF; i++) {
        (*sums)[2u * i] = times(at + 4u, line[i], (*sums)[2u * i]);
        let odd = times(at + 8u, line[i], (*sums)[2u * i + 1u]);
        (*sums)[2u * i + 1u] = times(at, line[i + 1u], odd);
    }
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let task = task_of(id);
    if task.idle {
        return;
    }
    var sums = begun(task);
    let first = dispatch.own.weights + dispatch.own.out_blocks + task.block * dispatch.own.blocks * 108u;
    for (var block = dispatch.own.first_in; block < dispatch.own.end_in; block++) {
        for (var k = 0u; k <= task.z % 2u; k++) {
            let z = task.z / 2u + k;
            for (var j = 0u; j <= task.y % 2u; j++) {
                let y = task.y / 2u + j;
                if z < dispatch.own.in_planes && y < dispatch.own.in_rows {
                    // Tap 1 of an even place; of an odd one tap 2, then tap 0.
                    let plane = select(1u, 2u - 2u * k, task.z % 2u == 1u);
                    let row = select(1u, 2u - 2u * j, task.y % 2u == 1u);
                    let at = first + ((block * 3u + plane) * 3u + row) * 12u;
                    add_line(place_of(block, z, y), task.x / 2u, z, at, &sums);
                }
            }
        }
    }
    store(task, sums);
}
