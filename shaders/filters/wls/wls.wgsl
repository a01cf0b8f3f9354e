// wls: the smoothed disparity times confidence, divided by the smoothed confidence; invalid where that is less than 2^-16.
// values -> filtered (i16)
// One invocation: a word, two pixels of a row.
// Border: none.
// With: common
// Reference: src/reference/filters/wls.rs

@group(0) @binding(2) var<storage, read> values: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> filtered: array<u32>;

// 2^-16 of the confidence 2^30.
const LEAST: u32 = 1u << 14u;

// To the nearest 1/16 px, bit by bit: the quotient is below 2, but for the rounding of the two.
fn disparity(value: vec2<u32>) -> i32 {
    var rest = min(value.x, 2u * value.y - 1u);
    var bits = 0u;
    for (var i = 0u; i < 32u - SIXTEENTH_BITS; i++) {
        let fits = rest >= value.y;
        rest = 2u * (rest - select(0u, value.y, fits));
        bits = 2u * bits + select(0u, 1u, fits);
    }
    let whole = min(i32((bits + 1u) >> 1u), 16 * (i32(DISPARITIES) - 1));
    return select(INVALID, 16 * frame.min_disparity + whole, value.y >= LEAST);
}

fn at(x: u32, y: u32) -> i32 {
    if x >= frame.width {
        return INVALID;
    }
    return disparity(values[y * frame.volume_stride + x]);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.map_stride || id.y >= dispatch.rows {
        return;
    }
    filtered[id.y * frame.map_stride + id.x] = map_word(at(2u * id.x, id.y), at(2u * id.x + 1u, id.y));
}
