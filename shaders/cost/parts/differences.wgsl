// Appended to the kernels that compare pixels: sixteen pairs of bytes at once.

// The absolute differences of sixteen pairs of bytes.
fn differences(a: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
    if SMALL_VALUES == 0u {
        return vec4(differences_of_any(a.x, b.x), differences_of_any(a.y, b.y), differences_of_any(a.z, b.z),
            differences_of_any(a.w, b.w));
    }
    // All bytes are below 128: with the top bit set, no byte borrows from the next. Negative ones are negated.
    let difference = (a | vec4(0x80808080u)) - b;
    let negative = ~difference & vec4(0x80808080u);
    let one = negative >> vec4(7u);
    return ((difference ^ (negative - one)) & vec4(0x7f7f7f7fu)) + one;
}

fn differences_of_any(a: u32, b: u32) -> u32 {
    return pack(vec4<u32>(abs(vec4<i32>(unpack(a)) - vec4<i32>(unpack(b)))));
}

// floor((a + b) / 2) of bytes.
fn byte_means(a: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
    return (a & b) + (((a ^ b) >> vec4(1u)) & vec4(0x7f7f7f7fu));
}

// The even and the odd bytes as words of 16-bit halves, in the order of `columns`.
fn low_pairs(bytes: vec4<u32>) -> vec4<u32> {
    return vec4(bytes.x, bytes.x >> 8u, bytes.y, bytes.y >> 8u) & vec4(0xff00ffu);
}

fn high_pairs(bytes: vec4<u32>) -> vec4<u32> {
    return vec4(bytes.z, bytes.z >> 8u, bytes.w, bytes.w >> 8u) & vec4(0xff00ffu);
}

// The bytes of a pixel in each plane, four times a word; and in each plane the bytes of sixteen pixels.
alias Pixel = array<u32, PLANES>;
alias Window = array<vec4<u32>, PLANES>;
