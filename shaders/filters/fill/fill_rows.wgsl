// fill_rows: for each pixel the nearest valid value of its row on the left, itself included, and on the right. Clears seen.
// map (i16, in a texture) -> nearest (i16, eight on the left and eight on the right in turns), seen (a bit a pixel)
// One invocation: a row in one direction.
// With: map_octet, common
// Reference: src/reference/filters/fill.rs

@group(0) @binding(3) var<storage, read_write> nearest: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> seen: array<u32>;

// The last valid one of two.
fn after(before: i32, value: i32) -> i32 {
    return select(value, before, value == INVALID);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.rows {
        return;
    }
    let stride = frame.map_stride / 4u;
    let row = dispatch.first_row + id.x;
    var last = INVALID;
    for (var n = 0u; n < stride; n++) {
        if id.y == 0u {
            seen[row * stride + n] = 0u;
        }
        let i = select(n, stride - 1u - n, id.y == 1u);
        let p = octet(row, i);
        var even = p.even;
        var odd = p.odd;
        if id.y == 0u {
            even.x = after(last, even.x);
            odd.x = after(even.x, odd.x);
            even.y = after(odd.x, even.y);
            odd.y = after(even.y, odd.y);
            even.z = after(odd.y, even.z);
            odd.z = after(even.z, odd.z);
            even.w = after(odd.z, even.w);
            odd.w = after(even.w, odd.w);
            last = odd.w;
        } else {
            odd.w = after(last, odd.w);
            even.w = after(odd.w, even.w);
            odd.z = after(even.w, odd.z);
            even.z = after(odd.z, even.z);
            odd.y = after(even.z, odd.y);
            even.y = after(odd.y, even.y);
            odd.x = after(even.y, odd.x);
            even.x = after(odd.x, even.x);
            last = even.x;
        }
        nearest[2u * (id.x * (stride + 1u) + i) + id.y] = pack_octet(even, odd);
    }
}
