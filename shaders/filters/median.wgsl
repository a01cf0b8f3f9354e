// median: the fifth of the 3x3 values around a pixel in ascending order, invalid below every valid value.
// map (i16, in a texture) -> filtered (i16)
// One invocation: four words, eight pixels of a row.
// Border: coordinates are clamped into the image; a result that points outside the right image is invalid.
// With: map_octet, invalidate_outside, common
// Reference: src/reference/filters/median.rs

@group(0) @binding(3) var<storage, read_write> filtered: array<vec4<u32>>;

// The values of columns x .. x + 7, the even and the odd ones, and of the columns x - 1 and x + 8.
struct Values {
    before: i32,
    even: vec4<i32>,
    odd: vec4<i32>,
    after: i32,
}

// A column of three values, ascending.
struct Column {
    low: vec4<i32>,
    middle: vec4<i32>,
    high: vec4<i32>,
}

fn values(row: u32, i: u32) -> Values {
    let stride = frame.map_stride / 4u;
    let start = row * stride;
    let words = map_at(start + i);
    let even = even_values(words);
    let odd = odd_values(words);
    let before = map_value(map_at(start + max(i, 1u) - 1u).w, 1u);
    let after = map_value(map_at(start + min(i + 1u, stride - 1u)).x, 0u);
    // The column after the last one repeats it, as the one before the first does.
    let beyond = vec4(i32(frame.width) - i32(8u * i));
    return Values(
        select(before, even.x, i == 0u),
        select(even, vec4(before, odd.xyz), vec4(0, 2, 4, 6) == beyond),
        select(odd, even, vec4(1, 3, 5, 7) == beyond),
        select(after, odd.w, 8 == beyond.x));
}

fn column(a: vec4<i32>, b: vec4<i32>, c: vec4<i32>) -> Column {
    let low = min(a, b);
    let high = max(a, b);
    return Column(min(low, c), max(low, min(high, c)), max(high, c));
}

fn middle(a: vec4<i32>, b: vec4<i32>, c: vec4<i32>) -> vec4<i32> {
    return max(min(a, b), min(max(a, b), c));
}

// The median of nine is the middle of: the largest minimum, the middle middle and the smallest maximum of the columns.
fn median(a: Column, b: Column, c: Column) -> vec4<i32> {
    return middle(max(max(a.low, b.low), c.low), middle(a.middle, b.middle, c.middle), min(min(a.high, b.high), c.high));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let y = dispatch.first_row + id.y;
    let a = values(max(y, 1u) - 1u, id.x);
    let b = values(y, id.x);
    let c = values(min(y + 1u, frame.height - 1u), id.x);
    let even = column(a.even, b.even, c.even);
    let odd = column(a.odd, b.odd, c.odd);
    // The neighbours of the even columns on the left, of the odd ones on the right.
    let left = column(vec4(a.before, a.odd.xyz), vec4(b.before, b.odd.xyz), vec4(c.before, c.odd.xyz));
    let right = column(vec4(a.even.yzw, a.after), vec4(b.even.yzw, b.after), vec4(c.even.yzw, c.after));
    let e = median(left, even, odd);
    let o = median(even, odd, right);
    let x = vec4(0, 2, 4, 6) + vec4(i32(8u * id.x));
    filtered[id.y * stride + id.x] = pack_octet(invalidate_outside(x, e), invalidate_outside(x + vec4(1), o));
}
