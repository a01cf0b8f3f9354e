// Appended to the convolutions of images and volumes. DEPTH and SIDE: planes, and rows and columns, of the neighbourhood; STRIDE and
// DILATION: values of the input from one output, and from one tap, to the next. `place_of` and `reaches` say where values lie.
// One invocation: four channels of COLUMNS columns. Beyond the border of the input there are zeros.

const LINE: u32 = (COLUMNS - 1u) * STRIDE + (SIDE - 1u) * DILATION + 1u;

// The weights of the taps of a line, four channels each: twelve or, of one tap, the first four.
alias Taps = array<vec4<f32>, 12>;

// All invocations go through all loops: neighbours may give weights to each other.
fn convolve(task: Task, lane: u32) {
    var sums = begun(task);
    let all = DEPTH * SIDE * SIDE * 4u;
    let first = dispatch.own.weights + dispatch.own.out_blocks + task.block * dispatch.own.blocks * all;
    // Numbers below zero are larger than all others.
    let left = task.x * STRIDE - (SIDE / 2u) * DILATION;
    for (var block = dispatch.own.first_in; block < dispatch.own.end_in; block++) {
        for (var k = 0u; k < DEPTH; k++) {
            let z = task.z * select(1u, STRIDE, DEPTH > 1u) + k - DEPTH / 2u;
            for (var j = 0u; j < SIDE; j++) {
                let y = task.y * STRIDE + j * DILATION - (SIDE / 2u) * DILATION;
                let taps = taps_at(first + ((block * DEPTH + k) * SIDE + j) * SIDE * 4u, lane);
                if !task.idle && z < dispatch.own.in_planes && y < dispatch.own.in_rows {
                    let place = place_of(block, z, y) + left;
                    var line = array<vec4<f32>, LINE>();
                    for (var i = 0u; i < LINE; i++) {
                        let inside = reaches(left + i, z);
                        line[i] = select(vec4(0.0), value_at(select(0u, place + i, inside)), inside);
                    }
                    add_line(line, taps, &sums);
                }
            }
        }
    }
    store(task, sums);
}

// Adds the products of a line with its taps.
fn add_line(values: array<vec4<f32>, LINE>, weights_of: Taps, sums: ptr<function, array<vec4<f32>, COLUMNS>>) {
    var line = values;
    var taps = weights_of;
    for (var i = 0u; i < SIDE; i++) {
        for (var c = 0u; c < COLUMNS; c++) {
            let value = line[c * STRIDE + i * DILATION];
            let a = fma(taps[4u * i], vec4(value.x), (*sums)[c]);
            let b = fma(taps[4u * i + 1u], vec4(value.y), a);
            (*sums)[c] = fma(taps[4u * i + 3u], vec4(value.w), fma(taps[4u * i + 2u], vec4(value.z), b));
        }
    }
}
