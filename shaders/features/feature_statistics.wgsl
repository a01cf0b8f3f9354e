// feature_statistics: the mean of an image in 256ths of one of 256 levels, and its deviation in units of four of these.
// counts (u32, of 1024 bins) -> statistics (u32: mean, deviation)
// One workgroup: LANES invocations of OWN_BINS bins each.
// With: root, common
// Reference: src/reference/features/feature_statistics.rs

struct Own {
    shift: u32,        // bits by which counts are shifted down, so that sums fit 32 bits
}

@group(0) @binding(2) var<storage, read> counts: array<u32>;
@group(0) @binding(3) var<storage, read_write> statistics: array<u32>;

const OWN_BINS: u32 = 1024u / LANES;

var<workgroup> numbers: array<u32, LANES>;
var<workgroup> sums: array<u32, LANES>;
var<workgroup> squares: array<u32, LANES>;

fn count_of(bin: u32) -> u32 {
    let shift = dispatch.own.shift & 31u;
    return (counts[bin] + ((1u << shift) >> 1u)) >> shift;
}

@compute @workgroup_size(LANES)
fn main(@builtin(local_invocation_index) local: u32) {
    let first = OWN_BINS * local;
    var own: array<u32, OWN_BINS>;
    var own_number = 0u;
    var own_sum = 0u;
    for (var i = 0u; i < OWN_BINS; i++) {
        own[i] = count_of(first + i);
        own_number += own[i];
        own_sum += own[i] * (first + i);
    }
    numbers[local] = own_number;
    sums[local] = own_sum;
    workgroupBarrier();
    var number = 0u;
    var sum = 0u;
    for (var i = 0u; i < LANES; i++) {
        number += numbers[i];
        sum += sums[i];
    }
    let centre = sum / number;
    var own_square = 0u;
    for (var i = 0u; i < OWN_BINS; i++) {
        let distance = max(first + i, centre) - min(first + i, centre);
        own_square += own[i] * distance * distance;
    }
    squares[local] = own_square;
    workgroupBarrier();
    var square = 0u;
    for (var i = 0u; i < LANES; i++) {
        square += squares[i];
    }
    let mean = 64u * sum / number;
    let rest = mean - 64u * centre;
    let variance = 256u * (square / number) + 256u * (square % number) / number - ((rest * rest) >> 4u);
    if local == 0u {
        statistics[0] = mean + 32u * DEEP;
        statistics[1] = max(integer_root(variance), 1u);
    }
}
