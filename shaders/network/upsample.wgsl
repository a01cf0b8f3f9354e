// upsample: bilinear interpolation of the images of both sides to another size.
// values (f32, [block of 4 channels][side][row][column][channel]) -> result, laid out alike
// One invocation: four channels of a pixel.
// Border: the values at the border go on.
// With: between, image_layer, common
// Chosen: values*
// Reference: src/reference/network/upsampling.rs

@group(0) @binding(3) var<storage, read_write> result: array<vec4<f32>>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.own.columns * dispatch.own.rows {
        return;
    }
    let corners = dispatch.own.rule == 1u;
    let x = between(id.x % dispatch.own.columns, dispatch.own.columns, dispatch.own.in_columns, corners);
    let y = between(id.x / dispatch.own.columns, dispatch.own.rows, dispatch.own.in_rows, corners);
    let block = id.y / 2u;
    let side = id.y % 2u;
    let first = dispatch.own.in_at + block * dispatch.own.in_stride + side * dispatch.own.in_rows * dispatch.own.in_columns;
    let low = first + y.low * dispatch.own.in_columns;
    let high = first + y.high * dispatch.own.in_columns;
    let upper = mix(value_at(low + x.low), value_at(low + x.high), x.part);
    let lower = mix(value_at(high + x.low), value_at(high + x.high), x.part);
    let at = block * dispatch.own.out_stride + side * dispatch.own.rows * dispatch.own.columns + id.x;
    result[at] = mix(upper, lower, y.part);
}
