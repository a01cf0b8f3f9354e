// fill_seen: the left pixels that a right pixel's disparity, or one that differs by at most fill_max_difference, points to.
// right_map (i16) -> seen (a bit a pixel, map_stride / 4 words a row), cleared before
// One invocation: four words, eight right pixels.
// With: common
// Reference: src/reference/filters/fill.rs

@group(0) @binding(2) var<storage, read> right_map: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> seen: array<atomic<u32>>;

// Sets the bits of columns first .. last of a row.
fn mark(row: u32, first: i32, last: i32) {
    let stride = i32(frame.map_stride / 4u);
    let low = max(first, 0);
    let high = min(last, i32(frame.width) - 1);
    for (var word = low >> 5u; word <= high >> 5u && low <= high; word++) {
        let from_bit = u32(clamp(low - 32 * word, 0, 31));
        let to_bit = u32(clamp(high - 32 * word, 0, 31));
        atomicOr(&seen[i32(row) * stride + word], (0xffffffffu << from_bit) & (0xffffffffu >> (31u - to_bit)));
    }
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let row = dispatch.first_row + id.y;
    let words = right_map[id.y * stride + id.x];
    // The columns that neighbours mark usually overlap, and are marked together.
    var first = 0;
    var last = -1;
    let largest = frame.min_disparity + i32(DISPARITIES) - 1;
    for (var j = 0u; j < 8u; j++) {
        let x = i32(8u * id.x + j);
        let value = map_value(words[j >> 1u], j);
        if x < i32(frame.width) && value != INVALID {
            let begin = x + max((value >> 4u) - frame.fill_max_difference, frame.min_disparity);
            let end = x + min((value >> 4u) + frame.fill_max_difference, largest);
            if begin <= last + 1 && end + 1 >= first {
                first = min(first, begin);
                last = max(last, end);
            } else {
                mark(row, first, last);
                first = begin;
                last = end;
            }
        }
    }
    mark(row, first, last);
}
