// validity: a disparity is kept if its pixel has content, and so have the pixels of the other view that it points to: columns
//   floor(P / 16) and ceil(P / 16), P = 16 x - disparity in the left view and 16 x + disparity in the right one.
// map (i16), contents (a bit a pixel, rows of whole words; the left view, then the right one) -> valid (i16)
// One invocation: four words, eight pixels of a row.
// Border: the content of the border pixels is repeated.
// With: check_octet, common
// Reference: src/reference/filters/validity.rs

struct Own {
    side: u32,          // of the map: 0 the left view, 1 the right one
}

@group(0) @binding(2) var<storage, read> map: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> contents: array<u32>;
@group(0) @binding(4) var<storage, read_write> valid: array<vec4<u32>>;

fn has_content(side: u32, x: i32, row: u32) -> bool {
    let column = u32(clamp(x, 0, i32(frame.width) - 1));
    let word = contents[(side * frame.height + row) * ((frame.width + 31u) / 32u) + column / 32u];
    return ((word >> (column & 31u)) & 1u) == 1u;
}

fn check(value: i32, x: i32, row: u32) -> i32 {
    let place = 16 * x + select(-value, value, dispatch.own.side == 1u);
    let other = 1u - dispatch.own.side;
    let stays = has_content(dispatch.own.side, x, row) && has_content(other, place >> 4u, row)
        && has_content(other, (place + 15) >> 4u, row);
    return select(INVALID, value, stays);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let at = id.y * stride + id.x;
    valid[at] = check_octet(map[at], i32(8u * id.x), dispatch.first_row + id.y);
}
