// Appended to the kernels that work on sixteen bytes at once: four words, the lowest byte first.

// A mask of the n lowest bytes; n may lie outside 0 .. 16.
fn low_bytes(n: i32) -> vec4<u32> {
    let in_word = vec4(n) - vec4(0, 4, 8, 12);
    let some = (vec4(1u) << (vec4<u32>(clamp(in_word, vec4(0), vec4(3))) * 8u)) - vec4(1u);
    return select(some, vec4(0xffffffffu), in_word >= vec4(4));
}

// The bits of `b` where the mask has ones, those of `a` elsewhere.
fn select_bits(a: vec4<u32>, b: vec4<u32>, mask: vec4<u32>) -> vec4<u32> {
    return (a & ~mask) | (b & mask);
}

// Sixteen copies of byte k, or of the last byte if k is larger.
fn byte_at(words: vec4<u32>, k: i32) -> vec4<u32> {
    let index = u32(clamp(k, 0, 15));
    return vec4(extractBits(words[index >> 2u], (index & 3u) * 8u, 8u) * 0x01010101u);
}

// Four of eight words, from the word at offset & 3 on.
fn from_word(a: vec4<u32>, b: vec4<u32>, offset: u32) -> vec4<u32> {
    let two = vec4((offset & 2u) != 0u);
    let c = select(a, vec4(a.zw, b.xy), two);
    return select(c, vec4(c.yzw, select(b.x, b.z, two.x)), vec4((offset & 1u) != 0u));
}

// Sixteen of twenty bytes, from the byte at offset & 3 on.
fn from_byte(words: vec4<u32>, next: u32, offset: u32) -> vec4<u32> {
    let shift = vec4((offset & 3u) * 8u);
    return (words >> shift) | ((vec4(words.yzw, next) << vec4(1u)) << (vec4(31u) - shift));
}
