// fill_lines: as fill_rows, on lines that go dx columns to the right from row to row: the nearest above, and below.
// map (i16, in a texture) -> nearest (i16, [y][line, eight][above, below]; a line is named by its column in row 0)
// carry (i16, [line, eight][down, up]): the nearest so far, from one batch of rows to the next in the direction.
// One invocation: eight neighbouring lines in one direction, 0 down and 1 up; the first is dispatch.entry.
// With: line_octet, line_slots, bytes, map_octet, common
// Reference: src/reference/filters/fill.rs

@group(0) @binding(3) var<storage, read_write> nearest: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> carry: array<vec4<u32>>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.lines {
        return;
    }
    let group = i32(id.x) - i32(dispatch.shift);
    let way = id.y + u32(dispatch.entry);
    let rows = rows_of(group);
    var even = vec4(INVALID);
    var odd = vec4(INVALID);
    if dispatch.carried == 1u {
        let before = carry[2u * id.x + way];
        even = even_values(before);
        odd = odd_values(before);
    }
    for (var n = 0; n <= rows.y - rows.x; n++) {
        let y = select(rows.x + n, rows.y - n, way == 1u);
        let x = 8 * group + dispatch.dx * y;
        let eight = eight_from(x, y);
        even = select(eight.even, even, eight.even == vec4(INVALID));
        odd = select(eight.odd, odd, eight.odd == vec4(INVALID));
        nearest[2u * slot_of(group, y, dispatch.dx) + way] = pack_octet(even, odd);
    }
    carry[2u * id.x + way] = pack_octet(even, odd);
}
