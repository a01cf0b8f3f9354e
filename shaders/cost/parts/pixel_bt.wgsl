// Appended to the kernels that compare pixels: the distance of a value from the interval around the other one, the
// smaller of the two ways round. Planes: value, lower and upper bound; three times that for three colours.
fn pixel_costs(left: Pixel, right: Window) -> vec4<u32> {
    var ls = left;
    var rs = right;
    var costs: array<vec4<u32>, CHANNELS>;
    for (var c = 0u; c < CHANNELS; c++) {
        let l = vec4(ls[3u * c]);
        let r = rs[3u * c];
        // Of a value's distances from two bounds one is 0.
        let there = above(rs[3u * c + 1u], l) | above(l, rs[3u * c + 2u]);
        let back = above(vec4(ls[3u * c + 1u]), r) | above(r, vec4(ls[3u * c + 2u]));
        costs[c] = there - above(there, back);
    }
    if CHANNELS == 3u {
        return average(average(costs[0], costs[CHANNELS - 1u]), costs[1u % CHANNELS]);
    }
    return costs[0];
}

// max(a - b, 0) of bytes.
fn above(a: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
    if SMALL_VALUES == 0u {
        return vec4(above_of_any(a.x, b.x), above_of_any(a.y, b.y), above_of_any(a.z, b.z), above_of_any(a.w, b.w));
    }
    let difference = (a | vec4(0x80808080u)) - b;
    return difference & (((difference >> vec4(7u)) & vec4(0x01010101u)) * 0x7fu);
}

fn above_of_any(a: u32, b: u32) -> u32 {
    return pack(vec4<u32>(max(vec4<i32>(unpack(a)) - vec4<i32>(unpack(b)), vec4(0))));
}
