// fill_rows_gray: as fill_rows, with the gray of the pixel that a value comes from.
// map (i16, in a texture), gray (u8, of the left image, in a texture) -> nearest (keys, u32, eight on the left and eight on the
//   right in turns)
// One invocation: a row in one direction.
// With: keys, gray_octet, map_octet, common
// Reference: src/reference/filters/fill.rs

@group(0) @binding(3) var<storage, read_write> nearest: array<vec4<u32>>;

// The last valid one of two.
fn after(before: u32, key: u32) -> u32 {
    return select(key, before, key == 0u);
}

// In the other order, or in this one.
fn turned(keys: Keys, turn: bool) -> Keys {
    return Keys(select(keys.low, keys.high.wzyx, vec4(turn)), select(keys.high, keys.low.wzyx, vec4(turn)));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.rows {
        return;
    }
    let stride = frame.map_stride / 4u;
    let row = dispatch.first_row + id.x;
    let leftwards = id.y == 1u;
    var last = 0u;
    for (var n = 0u; n < stride; n++) {
        let i = select(n, stride - 1u - n, leftwards);
        let p = octet(row, i);
        var keys = turned(keys_of(p.even, p.odd, gray_words(row, i + 2u)), leftwards);
        keys.low.x = after(last, keys.low.x);
        keys.low.y = after(keys.low.x, keys.low.y);
        keys.low.z = after(keys.low.y, keys.low.z);
        keys.low.w = after(keys.low.z, keys.low.w);
        keys.high.x = after(keys.low.w, keys.high.x);
        keys.high.y = after(keys.high.x, keys.high.y);
        keys.high.z = after(keys.high.y, keys.high.z);
        keys.high.w = after(keys.high.z, keys.high.w);
        last = keys.high.w;
        keys = turned(keys, leftwards);
        let at = 4u * (id.x * (stride + 1u) + i) + 2u * id.y;
        nearest[at] = keys.low;
        nearest[at + 1u] = keys.high;
    }
}
