// Appended to the kernels that compare pixels: the distance of a value from the interval around the other one, the
// smaller of the two ways round. Planes of each image: value, lower and upper bound; of one image, of the prefiltered and the gray
// one, or of three colours.
fn pixel_costs(left: Pixel, right: Window) -> vec4<u32> {
    var ls = left;
    var rs = right;
    var costs: array<vec4<u32>, DESCRIBED>;
    for (var c = 0u; c < DESCRIBED; c++) {
        let l = vec4(ls[3u * c]);
        let r = rs[3u * c];
        // Of a value's distances from two bounds one is 0.
        let there = above(rs[3u * c + 1u], l) | above(l, rs[3u * c + 2u]);
        let back = above(vec4(ls[3u * c + 1u]), r) | above(r, vec4(ls[3u * c + 2u]));
        costs[c] = there - above(there, back);
    }
    if DESCRIBED == 3u {
        return byte_means(byte_means(costs[0], costs[DESCRIBED - 1u]), costs[1u % DESCRIBED]);
    }
    if DESCRIBED == 2u {
        let quarter = (costs[1u % DESCRIBED] >> vec4(2u)) & vec4(0x3f3f3f3fu);
        return quarter + costs[0] - above(costs[0], ~quarter); // at most 255
    }
    return costs[0];
}

// max(a - b, 0) of bytes.
fn above(a: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
    let top = vec4(0x80808080u);
    if SMALL_VALUES == 1u {
        let difference = (a | top) - b;
        return difference & (((difference >> vec4(7u)) & vec4(0x01010101u)) * 0x7fu);
    }
    let low_bits = (a | top) - (b & ~top); // the top bit: no less in the lower seven
    let difference = low_bits ^ (~(a ^ b) & top);
    let not_less = (a & ~b) | (~(a ^ b) & low_bits);
    return difference & (((not_less >> vec4(7u)) & vec4(0x01010101u)) * 0xffu);
}
