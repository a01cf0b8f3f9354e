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

// The bits that differ, counted in each byte. Full adders first bring three planes to two: a sum, and a carry that
// counts twice.
fn differing_bits(left: Pixel, right: Window) -> vec4<u32> {
    var l = left;
    var r = right;
    var d: Window;
    for (var p = 0u; p < PLANES; p++) {
        d[p] = vec4(l[p]) ^ r[p];
    }
    if CENSUS_PLANES == 3u {
        return in_bytes(in_nibbles(d[0]) + in_nibbles(d[1u % PLANES]) + in_nibbles(d[2u % PLANES]));
    }
    if CENSUS_PLANES == 4u {
        let twos = majority(d[0], d[1u % PLANES], d[2u % PLANES]);
        let ones = d[0] ^ d[1u % PLANES] ^ d[2u % PLANES];
        return in_bytes(in_nibbles(ones) + in_nibbles(d[3u % PLANES])) + 2u * in_bytes(in_nibbles(twos));
    }
    let twos_a = majority(d[0], d[1u % PLANES], d[2u % PLANES]);
    let ones_a = d[0] ^ d[1u % PLANES] ^ d[2u % PLANES];
    let twos_b = majority(d[3u % PLANES], d[4u % PLANES], d[5u % PLANES]);
    let ones_b = d[3u % PLANES] ^ d[4u % PLANES] ^ d[5u % PLANES];
    if CENSUS_PLANES == 6u {
        return in_bytes(in_nibbles(ones_a) + in_nibbles(ones_b)) + 2u * in_bytes(in_nibbles(twos_a) + in_nibbles(twos_b));
    }
    let twos_c = majority(ones_a, ones_b, d[6u % PLANES]);
    let ones_c = ones_a ^ ones_b ^ d[6u % PLANES];
    let fours = majority(twos_a, twos_b, twos_c);
    let twos = twos_a ^ twos_b ^ twos_c;
    return in_bytes(in_nibbles(ones_c) + in_nibbles(d[7u % PLANES]))
        + 2u * in_bytes(in_nibbles(twos) + 2u * in_nibbles(fours));
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
