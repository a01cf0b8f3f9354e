// fill_lines_gray: as fill_lines, with the gray of the pixel that a value comes from.
// map (i16, in a texture), gray (u8, of the left image, in a texture) -> nearest (keys, u32, [y][line, eight][above, below]; a line
//   is named by its column in row 0)
// carry (keys, [line, eight][down, up]): the nearest so far, from one batch of rows to the next in the direction.
// One invocation: eight neighbouring lines in one direction, 0 down and 1 up; the first is dispatch.entry.
// With: keys, gray_octet, bytes, map_octet, common
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
    let stride = i32(frame.map_stride / 4u);
    let width = i32(frame.width);
    let group = i32(id.x) - i32(dispatch.shift);
    let way = id.y + u32(dispatch.entry);
    // The rows in which one of the eight lies in the image.
    let begin = i32(dispatch.first_row);
    var first = begin;
    var last = begin + i32(dispatch.rows) - 1;
    if dispatch.dx > 0 {
        first = max(first, -7 - 8 * group);
        last = min(last, width - 1 - 8 * group);
    } else if dispatch.dx < 0 {
        first = max(first, 8 * group - width + 1);
        last = min(last, 8 * group + 7);
    }
    var last_low = vec4(0u);
    var last_high = vec4(0u);
    if dispatch.carried == 1u {
        let before = 4u * id.x + 2u * way;
        last_low = carry[before];
        last_high = carry[before + 1u];
    }
    for (var n = 0; n <= last - first; n++) {
        let y = select(first + n, last - n, way == 1u);
        let x = 8 * group + dispatch.dx * y;
        let at = x >> 3u;
        let a = map_at(u32(y * stride + clamp(at, 0, stride - 1)));
        let b = map_at(u32(y * stride + clamp(at + 1, 0, stride - 1)));
        let offset = u32(x & 7);
        let words = from_byte(from_word(a, b, offset >> 1u), from_word(b, b, offset >> 1u).x, 2u * offset);
        let low = even_values(words);
        let high = odd_values(words);
        let columns = vec4(x) + vec4(0, 2, 4, 6);
        let e = select(vec4(INVALID), low, (columns >= vec4(0)) & (columns < vec4(width)));
        let o = select(vec4(INVALID), high, (columns >= vec4(-1)) & (columns < vec4(width - 1)));
        let keys = keys_of(e, o, grays_from(x, y));
        last_low = select(keys.low, last_low, keys.low == vec4(0u));
        last_high = select(keys.high, last_high, keys.high == vec4(0u));
        let slot = (y - begin) * (stride + 1) + group - ((-dispatch.dx * y) >> 3u);
        let to = 4u * u32(slot) + 2u * way;
        nearest[to] = last_low;
        nearest[to + 1u] = last_high;
    }
    let to = 4u * id.x + 2u * way;
    carry[to] = last_low;
    carry[to + 1u] = last_high;
}
