// Appended to the kernels that make costs straight from the planes: sixteen absolute differences at once, and their sums
// in 16-bit halves of words.

// The absolute differences of sixteen pairs of bytes.
fn differences(a: u32, b: vec4<u32>) -> vec4<u32> {
    if SMALL_VALUES == 0u {
        return vec4(differences_of_any(a, b.x), differences_of_any(a, b.y), differences_of_any(a, b.z),
            differences_of_any(a, b.w));
    }
    // All bytes are below 128: with the top bit set, no byte borrows from the next. Negative ones are negated.
    let difference = vec4(a | 0x80808080u) - b;
    let negative = ~difference & vec4(0x80808080u);
    let one = negative >> vec4(7u);
    return ((difference ^ (negative - one)) & vec4(0x7f7f7f7fu)) + one;
}

fn differences_of_any(a: u32, b: u32) -> u32 {
    return pack(vec4<u32>(abs(vec4<i32>(unpack(a)) - vec4<i32>(unpack(b)))));
}

// The even and the odd bytes as words of 16-bit halves, in the order of `columns`.
fn low_pairs(bytes: vec4<u32>) -> vec4<u32> {
    return vec4(bytes.x, bytes.x >> 8u, bytes.y, bytes.y >> 8u) & vec4(0xff00ffu);
}

fn high_pairs(bytes: vec4<u32>) -> vec4<u32> {
    return vec4(bytes.z, bytes.z >> 8u, bytes.w, bytes.w >> 8u) & vec4(0xff00ffu);
}

fn quantised_block(low: vec4<u32>, high: vec4<u32>) -> vec4<u32> {
    return vec4(quantised(unpack_pairs(low.x, low.y)), quantised(unpack_pairs(low.z, low.w)),
        quantised(unpack_pairs(high.x, high.y)), quantised(unpack_pairs(high.z, high.w)));
}
