// lr_check: a left pixel keeps its disparity if the right pixel at x - q, q = floor((disparity + 8) / 16), is valid and
//   its disparity in whole pixels differs from q by at most lr_max_difference.
// left_map, right_map (i16) -> checked (i16)
// One invocation: one word, two pixels of a row.
// Border: a disparity that points outside the right image is invalid.
// Reference: src/reference/lr_check.rs

@group(0) @binding(2) var<storage, read> left_map: array<u32>;
@group(0) @binding(3) var<storage, read> right_map: array<u32>;
@group(0) @binding(4) var<storage, read_write> checked: array<u32>;

fn check(value: i32, x: i32, row: u32) -> i32 {
    if value == INVALID || !points_inside(x, value) {
        return INVALID;
    }
    let whole = (value + 8) >> 4u;
    let seen_at = u32(x - whole);
    let seen = map_value(right_map[row * frame.map_stride + (seen_at >> 1u)], seen_at);
    let agrees = seen != INVALID && u32(abs((seen >> 4u) - whole)) <= frame.lr_max_difference;
    return select(INVALID, value, agrees);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.map_stride || id.y >= frame.height {
        return;
    }
    let at = id.y * frame.map_stride + id.x;
    let word = left_map[at];
    let x = 2u * id.x;
    checked[at] = map_word(check(map_value(word, 0u), i32(x), id.y), check(map_value(word, 1u), i32(x) + 1, id.y));
}
