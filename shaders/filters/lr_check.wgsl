// lr_check: a left pixel keeps its disparity if the right pixel at x - q, q = floor((disparity + 8) / 16), is valid and
//   its disparity in whole pixels differs from q by at most lr_max_difference.
// left_map, right_map (i16) -> checked (i16)
// One invocation: four words, eight pixels of a row.
// Border: a disparity that points outside the right image is invalid.
// With: check_octet, common
// Reference: src/reference/filters/lr_check.rs

@group(0) @binding(2) var<storage, read> left_map: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> right_map: array<u32>;
@group(0) @binding(4) var<storage, read_write> checked: array<vec4<u32>>;

fn check(value: i32, x: i32, row: u32) -> i32 {
    let inside = value != INVALID && points_inside(x, value);
    let whole = (value + 8) >> 4u;
    let seen_at = select(0u, u32(x - whole), inside);
    let seen = map_value(right_map[row * frame.map_stride + (seen_at >> 1u)], seen_at);
    let agrees = inside && seen != INVALID && u32(abs((seen >> 4u) - whole)) <= frame.lr_max_difference;
    return select(INVALID, value, agrees);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let at = id.y * stride + id.x;
    checked[at] = check_octet(left_map[at], i32(8u * id.x), id.y);
}
