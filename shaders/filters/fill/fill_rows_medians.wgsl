// fill_rows_medians: for each invalid pixel the median of the three nearest valid values of its row on the left, and on the right,
//   or of as many as there are; of two the lower one. What stands at valid pixels nobody reads. Clears seen.
// map (i16, in a texture) -> nearest (i16, eight on the left and eight on the right in turns), seen (a bit a pixel)
// One invocation: a row in one direction.
// With: map_octet, common
// Reference: src/reference/filters/fill.rs

@group(0) @binding(3) var<storage, read_write> nearest: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> seen: array<u32>;

// The last three valid values, the last one in x; invalid where there are none yet.
fn after(before: vec3<i32>, value: i32) -> vec3<i32> {
    return select(vec3(value, before.xy), before, value == INVALID);
}

// Invalid is less than all values: with two of them the one in the middle is the lower, with one it is invalid.
fn median(v: vec3<i32>) -> i32 {
    let middle = max(min(v.x, v.y), min(max(v.x, v.y), v.z));
    return select(middle, v.x, middle == INVALID);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.rows {
        return;
    }
    let stride = frame.map_stride / 4u;
    let row = dispatch.first_row + id.x;
    let turn = vec4(id.y == 1u);
    var last = vec3(INVALID);
    for (var n = 0u; n < stride; n++) {
        if id.y == 0u {
            seen[row * stride + n] = 0u;
        }
        let i = select(n, stride - 1u - n, id.y == 1u);
        let p = octet(row, i);
        // Leftwards the last column is the first.
        let first = select(p.even, p.odd.wzyx, turn);
        let second = select(p.odd, p.even.wzyx, turn);
        var a = vec4(0);
        var b = vec4(0);
        last = after(last, first.x);
        a.x = median(last);
        last = after(last, second.x);
        b.x = median(last);
        last = after(last, first.y);
        a.y = median(last);
        last = after(last, second.y);
        b.y = median(last);
        last = after(last, first.z);
        a.z = median(last);
        last = after(last, second.z);
        b.z = median(last);
        last = after(last, first.w);
        a.w = median(last);
        last = after(last, second.w);
        b.w = median(last);
        nearest[2u * (id.x * (stride + 1u) + i) + id.y] = pack_octet(select(a, b.wzyx, turn), select(b, a.wzyx, turn));
    }
}
