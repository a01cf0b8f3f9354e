// median_five_parallel: median_five with the schedule per-subgroup: half the pixels an invocation, and so half the registers.
// map (i16, in a texture) -> filtered (i16)
// One invocation: two words, four pixels of a row.
// Border: coordinates are clamped into the image; a result that points outside the right image is invalid.
// With: median_of_25, map_octet, invalidate_outside, common
// Reference: src/reference/filters/median.rs

@group(0) @binding(3) var<storage, read_write> filtered: array<vec2<u32>>;

// The values of columns x .. x + 3, and of the two columns on either side: x - 2 and x - 1, x + 4 and x + 5.
struct Values {
    outer: vec4<i32>,
    inner: vec4<i32>,
}

// Lets the column `beyond` columns after x repeat the one before it.
fn repeated(v: Values, beyond: i32) -> Values {
    let inner = select(v.inner, vec4(v.outer.y, v.inner.xyz), vec4(0, 1, 2, 3) == vec4(beyond));
    let after = select(v.outer.zw, vec2(v.inner.w, v.outer.z), vec2(4, 5) == vec2(beyond));
    return Values(vec4(v.outer.xy, after), inner);
}

fn two_values(word: u32) -> vec2<i32> {
    return vec2(map_value(word, 0u), map_value(word, 1u));
}

fn values(row: i32, i: u32) -> Values {
    let stride = frame.map_stride / 4u;
    let start = u32(clamp(row, 0, i32(frame.height) - 1)) * stride;
    let upper = (i & 1u) == 1u;
    let words = map_at(start + i / 2u);
    let beside = map_at(start + select(max(i / 2u, 1u) - 1u, min(i / 2u + 1u, stride - 1u), upper));
    let here = select(words.xy, words.zw, upper);
    let inner = vec4(two_values(here.x), two_values(here.y));
    let before = select(two_values(select(beside.w, words.y, upper)), vec2(inner.x), i == 0u);
    let after = two_values(select(words.z, beside.x, upper));
    let beyond = i32(frame.width) - i32(4u * i);
    return repeated(repeated(Values(vec4(before, after), inner), beyond), beyond + 1);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 2u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let y = i32(dispatch.first_row + id.y);
    let a = values(y - 2, id.x);
    let b = values(y - 1, id.x);
    let c = values(y, id.x);
    let d = values(y + 1, id.x);
    let e = values(y + 2, id.x);
    let o = ascending(Five(a.outer, b.outer, c.outer, d.outer, e.outer));
    let i = ascending(Five(a.inner, b.inner, c.inner, d.inner, e.inner));
    let median = median(
        Five(vec4(o.a.xy, i.a.xy), vec4(o.b.xy, i.b.xy), vec4(o.c.xy, i.c.xy), vec4(o.d.xy, i.d.xy), vec4(o.e.xy, i.e.xy)),
        Five(vec4(o.a.y, i.a.xyz), vec4(o.b.y, i.b.xyz), vec4(o.c.y, i.c.xyz), vec4(o.d.y, i.d.xyz), vec4(o.e.y, i.e.xyz)),
        i,
        Five(vec4(i.a.yzw, o.a.z), vec4(i.b.yzw, o.b.z), vec4(i.c.yzw, o.c.z), vec4(i.d.yzw, o.d.z), vec4(i.e.yzw, o.e.z)),
        Five(vec4(i.a.zw, o.a.zw), vec4(i.b.zw, o.b.zw), vec4(i.c.zw, o.c.zw), vec4(i.d.zw, o.d.zw), vec4(i.e.zw, o.e.zw)));
    let x = vec4(0, 1, 2, 3) + vec4(i32(4u * id.x));
    let result = invalidate_outside(x, median);
    filtered[id.y * stride + id.x] = vec2(map_word(result.x, result.y), map_word(result.z, result.w));
}
