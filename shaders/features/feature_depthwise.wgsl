// feature_depthwise: a layer that sums over 3x3 pixels of the channel itself, as floats, which are exact below 2^24.
// values (bytes, [block of four channels][row][vector]), weights -> result, laid out alike, or of 16 bits
//   The weights of a block, in eight texels: three rows of three words, four biases, four multipliers, four shifts.
// One invocation: four channels of four columns of ROWS rows.
// Border: rows and columns are clamped into the image.
// With: neighbours, layer, common
// Chosen: texels_*
// Reference: src/reference/features/feature_layer.rs

const ROWS: u32 = 4u;

// Four channels each of six columns, of the four columns in their middle, and of three taps of a row.
alias Line = array<vec4<f32>, 6>;
alias Columns = array<vec4<f32>, 4>;
alias Taps = array<vec4<f32>, 3>;

fn line_at(block: u32, row: u32, vector: u32) -> Line {
    let words = six_columns(block, row, vector);
    return Line(channels(words[0]), channels(words[1]), channels(words[2]), channels(words[3]), channels(words[4]),
        channels(words[5]));
}

fn channels(word: u32) -> vec4<f32> {
    return vec4<f32>(unpack4xI8(word));
}

fn taps_of(row: vec4<u32>) -> Taps {
    return Taps(channels(row.x), channels(row.y), channels(row.z));
}

fn add(sums: ptr<function, Columns>, columns: Line, taps: Taps) {
    var line = columns;
    for (var c = 0u; c < 4u; c++) {
        (*sums)[c] = fma(taps[2], line[c + 2u], fma(taps[1], line[c + 1u], fma(taps[0], line[c], (*sums)[c])));
    }
}

fn leave_row(sums: Columns, block: u32, row: u32, vector: u32, multipliers: vec4<u32>, shifts: vec4<u32>) {
    let results = array(requantised(vec4<i32>(sums[0]), multipliers, shifts),
        requantised(vec4<i32>(sums[1]), multipliers, shifts), requantised(vec4<i32>(sums[2]), multipliers, shifts),
        requantised(vec4<i32>(sums[3]), multipliers, shifts));
    if row < dispatch.rows {
        leave(block, row, vector, results);
    }
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let vector = id.x % row_vectors();
    let top = id.x / row_vectors() * ROWS;
    let block = id.y;
    let texels = eight_texels(dispatch.own.weights + 8u * block, local % 8u);
    let above = taps_of(texels[0]);
    let here = taps_of(texels[1]);
    let below = taps_of(texels[2]);
    let bias = vec4<f32>(bitcast<vec4<i32>>(texels[3]));
    var a = Columns(bias, bias, bias, bias);
    var b = a;
    var c = a;
    var d = a;
    // In loops these sums would not stay in registers.
    let line0 = line_at(block, row_below(top, 0u), vector);
    add(&a, line0, above);
    let line1 = line_at(block, row_below(top, 1u), vector);
    add(&a, line1, here);
    add(&b, line1, above);
    let line2 = line_at(block, row_below(top, 2u), vector);
    add(&a, line2, below);
    add(&b, line2, here);
    add(&c, line2, above);
    let line3 = line_at(block, row_below(top, 3u), vector);
    add(&b, line3, below);
    add(&c, line3, here);
    add(&d, line3, above);
    let line4 = line_at(block, row_below(top, 4u), vector);
    add(&c, line4, below);
    add(&d, line4, here);
    let line5 = line_at(block, row_below(top, 5u), vector);
    add(&d, line5, below);
    leave_row(a, block, top, vector, texels[4], texels[5]);
    leave_row(b, block, top + 1u, vector, texels[4], texels[5]);
    leave_row(c, block, top + 2u, vector, texels[4], texels[5]);
    leave_row(d, block, top + 3u, vector, texels[4], texels[5]);
}
