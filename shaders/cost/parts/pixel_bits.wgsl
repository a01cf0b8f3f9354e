// Appended to the kernels that compare census strings: the number of bits that differ.
// Full adders bring three planes to two: a sum, and a carry that counts twice.
fn differing_bits(left: Pixel, right: Window) -> vec4<u32> {
    var l = left;
    var r = right;
    var d: array<vec4<u32>, 8>;
    for (var p = 0u; p < 8u; p++) {
        if p < CENSUS_PLANES {
            d[p] = vec4(l[min(p, PLANES - 1u)]) ^ r[min(p, PLANES - 1u)];
        }
    }
    let ones_a = d[0] ^ d[1] ^ d[2];
    let twos_a = majority(d[0], d[1], d[2]);
    let ones_b = d[3] ^ d[4] ^ d[5];
    let twos_b = majority(d[3], d[4], d[5]);
    let ones = ones_a ^ ones_b ^ d[6];
    let twos_c = majority(ones_a, ones_b, d[6]);
    let twos = twos_a ^ twos_b ^ twos_c;
    let fours = majority(twos_a, twos_b, twos_c);
    return in_bytes(in_nibbles(ones) + in_nibbles(d[7])) + 2u * in_bytes(in_nibbles(twos) + 2u * in_nibbles(fours));
}

fn majority(a: vec4<u32>, b: vec4<u32>, c: vec4<u32>) -> vec4<u32> {
    return (a & b) | ((a ^ b) & c);
}

// The ones of each half of a byte, at most 4.
fn in_nibbles(v: vec4<u32>) -> vec4<u32> {
    let pairs = v - ((v >> vec4(1u)) & vec4(0x55555555u));
    return (pairs & vec4(0x33333333u)) + ((pairs >> vec4(2u)) & vec4(0x33333333u));
}

// Both halves of each byte added.
fn in_bytes(nibbles: vec4<u32>) -> vec4<u32> {
    return (nibbles & vec4(0x0f0f0f0fu)) + ((nibbles >> vec4(4u)) & vec4(0x0f0f0f0fu));
}
