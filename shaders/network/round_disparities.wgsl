// round_disparities: floor(16 d + 1/2) of a disparity d, at least 0 and at most 16 (DISPARITIES - 1): 1/16 px.
// values (f32, [row][column], padded) -> map (i16)
// One invocation: a word of the map, two pixels of a row.
// Border: columns beyond the image get what is there.
// With: common
// Reference: src/reference/network/regression.rs

struct Own {
    columns: u32,   // a row of the disparities
    padding: u32,   // rows above the image
}

@group(0) @binding(2) var<storage, read> values: array<f32>;
@group(0) @binding(3) var<storage, read_write> map: array<u32>;

fn rounded(x: u32, y: u32) -> i32 {
    let value = 16.0 * values[(y + dispatch.own.padding) * dispatch.own.columns + min(x, frame.width - 1u)];
    // 16 d + 1/2 may not be a number of 32 bits; both parts of 16 d are.
    let whole = floor(value);
    return clamp(i32(whole) + select(0, 1, value - whole >= 0.5), 0, i32(16u * (DISPARITIES - 1u)));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.map_stride || id.y >= dispatch.rows {
        return;
    }
    let y = dispatch.first_row + id.y;
    let word = map_word(rounded(2u * id.x, y), rounded(2u * id.x + 1u, y));
    map[id.y * frame.map_stride + id.x] = word;
}
