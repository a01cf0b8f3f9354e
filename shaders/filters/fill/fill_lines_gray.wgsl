// fill_lines_gray: as fill_lines, with the gray of the pixel that a value comes from.
// map (i16, in a texture), gray (u8, of the left image, in a texture) -> nearest (keys, u32, [y][line, eight][above, below]; a line
//   is named by its column in row 0)
// carry (keys, [line, eight][down, up]): the nearest so far, from one batch of rows to the next in the direction.
// One invocation: eight neighbouring lines in one direction, 0 down and 1 up; the first is dispatch.entry.
// With: keys, line_octet, line_slots, gray_octet, bytes, map_octet, common
// Reference: src/reference/filters/fill.rs

@group(0) @binding(3) var<storage, read_write> nearest: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> carry: array<vec4<u32>>;

// The gray of eight columns from x on, which is -16 or more.
fn grays_from(x: i32, y: i32) -> vec2<u32> {
    let first = u32(x + 16);
    let at = u32(y) * frame.gray_stride + first / 16u;
    let a = textureLoad(gray, vec2(at % TEXELS, at / TEXELS));
    let b = textureLoad(gray, vec2((at + 1u) % TEXELS, (at + 1u) / TEXELS));
    return from_byte(from_word(a, b, first >> 2u), 0u, first).xy;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.lines {
        return;
    }
    let group = i32(id.x) - i32(dispatch.shift);
    let way = id.y + u32(dispatch.entry);
    let rows = rows_of(group);
    var last_low = vec4(0u);
    var last_high = vec4(0u);
    if dispatch.carried == 1u {
        let before = 4u * id.x + 2u * way;
        last_low = carry[before];
        last_high = carry[before + 1u];
    }
    for (var n = 0; n <= rows.y - rows.x; n++) {
        let y = select(rows.x + n, rows.y - n, way == 1u);
        let x = 8 * group + dispatch.dx * y;
        let eight = eight_from(x, y);
        let keys = keys_of(eight.even, eight.odd, grays_from(x, y));
        last_low = select(keys.low, last_low, keys.low == vec4(0u));
        last_high = select(keys.high, last_high, keys.high == vec4(0u));
        let to = 4u * slot_of(group, y, dispatch.dx) + 2u * way;
        nearest[to] = last_low;
        nearest[to + 1u] = last_high;
    }
    let to = 4u * id.x + 2u * way;
    carry[to] = last_low;
    carry[to + 1u] = last_high;
}
