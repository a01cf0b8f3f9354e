// median_five: the thirteenth of the 5x5 values around a pixel in ascending order, invalid below every valid value.
// map (i16, in a texture) -> filtered (i16)
// One invocation: four words, eight pixels of a row.
// Border: coordinates are clamped into the image; a result that points outside the right image is invalid.
// With: median_of_25, map_octet, invalidate_outside, common
// Reference: src/reference/filters/median.rs

@group(0) @binding(3) var<storage, read_write> filtered: array<vec4<u32>>;

// The values of columns x .. x + 7, the even and the odd ones, and of the two columns on either side: x - 2 and x - 1,
// x + 8 and x + 9.
struct Values {
    before: vec2<i32>,
    even: vec4<i32>,
    odd: vec4<i32>,
    after: vec2<i32>,
}

// Lets the column `beyond` columns after x repeat the one before it.
fn repeated(v: Values, beyond: i32) -> Values {
    return Values(
        v.before,
        select(v.even, vec4(v.before.y, v.odd.xyz), vec4(0, 2, 4, 6) == vec4(beyond)),
        select(v.odd, v.even, vec4(1, 3, 5, 7) == vec4(beyond)),
        select(v.after, vec2(v.odd.w, v.after.x), vec2(8, 9) == vec2(beyond)));
}

fn values(row: i32, i: u32) -> Values {
    let stride = frame.map_stride / 4u;
    let start = u32(clamp(row, 0, i32(frame.height) - 1)) * stride;
    let words = map_at(start + i);
    let before = map_at(start + max(i, 1u) - 1u).w;
    let after = map_at(start + min(i + 1u, stride - 1u)).x;
    let even = even_values(words);
    let left = select(vec2(map_value(before, 0u), map_value(before, 1u)), vec2(even.x), i == 0u);
    let read = Values(left, even, odd_values(words), vec2(map_value(after, 0u), map_value(after, 1u)));
    let beyond = i32(frame.width) - i32(8u * i);
    return repeated(repeated(read, beyond), beyond + 1);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let y = i32(dispatch.first_row + id.y);
    let a = values(y - 2, id.x);
    let b = values(y - 1, id.x);
    let c = values(y, id.x);
    let d = values(y + 1, id.x);
    let e = values(y + 2, id.x);
    let even = ascending(Five(a.even, b.even, c.even, d.even, e.even));
    let odd = ascending(Five(a.odd, b.odd, c.odd, d.odd, e.odd));
    // The columns x - 2, x - 1, x + 8 and x + 9.
    let sides = ascending(Five(vec4(a.before, a.after), vec4(b.before, b.after), vec4(c.before, c.after),
        vec4(d.before, d.after), vec4(e.before, e.after)));
    let left_even = Five(vec4(sides.a.x, even.a.xyz), vec4(sides.b.x, even.b.xyz), vec4(sides.c.x, even.c.xyz),
        vec4(sides.d.x, even.d.xyz), vec4(sides.e.x, even.e.xyz));
    let left_odd = Five(vec4(sides.a.y, odd.a.xyz), vec4(sides.b.y, odd.b.xyz), vec4(sides.c.y, odd.c.xyz),
        vec4(sides.d.y, odd.d.xyz), vec4(sides.e.y, odd.e.xyz));
    let right_even = Five(vec4(even.a.yzw, sides.a.z), vec4(even.b.yzw, sides.b.z), vec4(even.c.yzw, sides.c.z),
        vec4(even.d.yzw, sides.d.z), vec4(even.e.yzw, sides.e.z));
    let right_odd = Five(vec4(odd.a.yzw, sides.a.w), vec4(odd.b.yzw, sides.b.w), vec4(odd.c.yzw, sides.c.w),
        vec4(odd.d.yzw, sides.d.w), vec4(odd.e.yzw, sides.e.w));
    let x = vec4(0, 2, 4, 6) + vec4(i32(8u * id.x));
    filtered[id.y * stride + id.x] = pack_octet(
        invalidate_outside(x, median(left_even, left_odd, even, odd, right_even)),
        invalidate_outside(x + vec4(1), median(left_odd, even, odd, right_even, right_odd)));
}
