// Appended to the kernels that compare pixels: the number of bits of a census string that differ; with derivatives twice
// that and their absolute differences; with a value a blend of its absolute difference and the number of bits.
fn pixel_costs(left: Pixel, right: Window) -> vec4<u32> {
    let bits = differing_bits(left, right);
    if COST == COST_CENSUS_SOBEL {
        return 2u * bits + differences(vec4(left[min(CENSUS_PLANES, PLANES - 1u)]), right[min(CENSUS_PLANES, PLANES - 1u)])
            + differences(vec4(left[PLANES - 1u]), right[PLANES - 1u]);
    }
    if COST == COST_AD_CENSUS {
        let value = differences(vec4(left[PLANES - 1u]), right[PLANES - 1u]);
        return vec4(blend(value.x, bits.x), blend(value.y, bits.y), blend(value.z, bits.z), blend(value.w, bits.w));
    }
    return bits;
}

fn blend(value: u32, bits: u32) -> u32 {
    let weighted = AD_WEIGHT * unpack(value) + CENSUS_WEIGHT * unpack(bits) + vec4(8u);
    return pack(min(weighted >> vec4(4u), vec4(255u)));
}

// The bits that differ, counted in each byte. Full adders bring three planes to two: a sum, and a carry that counts twice.
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
