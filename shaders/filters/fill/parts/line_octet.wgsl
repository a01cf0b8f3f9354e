// Appended to the kernels that go along eight lines together, dispatch.dx columns to the right from row to row.

// The first and the last row in which one of the eight lies in the image.
fn rows_of(group: i32) -> vec2<i32> {
    let width = i32(frame.width);
    let first = i32(dispatch.first_row);
    let last = first + i32(dispatch.rows) - 1;
    if dispatch.dx > 0 {
        return vec2(max(first, -7 - 8 * group), min(last, width - 1 - 8 * group));
    }
    if dispatch.dx < 0 {
        return vec2(max(first, 8 * group - width + 1), min(last, 8 * group + 7));
    }
    return vec2(first, last);
}

struct Eight {
    even: vec4<i32>,
    odd: vec4<i32>,
}

// The pixels of a row from column x on; those outside the image are invalid.
fn eight_from(x: i32, y: i32) -> Eight {
    let stride = i32(frame.map_stride / 4u);
    let width = i32(frame.width);
    let at = x >> 3u;
    let a = map_at(u32(y * stride + clamp(at, 0, stride - 1)));
    let b = map_at(u32(y * stride + clamp(at + 1, 0, stride - 1)));
    let offset = u32(x & 7);
    let words = from_byte(from_word(a, b, offset >> 1u), from_word(b, b, offset >> 1u).x, 2u * offset);
    let columns = vec4(x) + vec4(0, 2, 4, 6);
    return Eight(
        select(vec4(INVALID), even_values(words), (columns >= vec4(0)) & (columns < vec4(width))),
        select(vec4(INVALID), odd_values(words), (columns >= vec4(-1)) & (columns < vec4(width - 1))));
}
