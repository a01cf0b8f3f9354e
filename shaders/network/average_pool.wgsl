// average_pool: the mean of squares of `rule` x `rule` values that do not overlap, from the top left.
// values (f32, [block of 4 channels][side][row][column][channel]) -> result, laid out alike
// One invocation: four channels of a square.
// Border: rows and columns that fill no whole square are left out.
// With: image_layer, common
// Chosen: values*
// Reference: src/reference/network/pooling.rs

@group(0) @binding(3) var<storage, read_write> result: array<vec4<f32>>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.own.columns * dispatch.own.rows {
        return;
    }
    let x = id.x % dispatch.own.columns;
    let y = id.x / dispatch.own.columns;
    let block = id.y / 2u;
    let sides = id.y % 2u;
    let side = dispatch.own.rule;
    let first = dispatch.own.in_at + block * dispatch.own.in_stride + sides * dispatch.own.in_rows * dispatch.own.in_columns;
    // Rows are summed by themselves first: sums of few values lose little.
    var sum = vec4(0.0);
    for (var j = 0u; j < side; j++) {
        var row = vec4(0.0);
        for (var i = 0u; i < side; i++) {
            row += value_at(first + (y * side + j) * dispatch.own.in_columns + x * side + i);
        }
        sum += row;
    }
    let at = block * dispatch.own.out_stride + sides * dispatch.own.rows * dispatch.own.columns + id.x;
    result[at] = sum / f32(side * side);
}
