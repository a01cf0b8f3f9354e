// Appended to the kernels that match blocks: the cost of a block is 4096 less its normalised cross correlation, in
// 4096ths, from the sum of products and the statistics of both blocks.
// Reference: src/reference/winner/block_match.rs

// The statistics of the right blocks that the disparities are compared with: sums and roots. A step to the left moves
// them down by one disparity.
struct Seen {
    sums: Costs,
    roots: Costs,
}

fn right_block(row: u32, place: u32) -> vec2<u32> {
    let count = frame.width + DISPARITIES - 1u;
    return statistics[row * (frame.width + count) + frame.width + min(place, count - 1u)];
}

// Before the first step: each statistic one disparity higher than that step has it.
fn none_seen(row: u32) -> Seen {
    var seen: Seen;
    for (var q = 0u; q < OWN_QUADS; q++) {
        for (var i = 0u; i < 4u; i++) {
            let place = member * OWN + 16u * q + 4u * i;
            let a = right_block(row, max(place, 1u) - 1u);
            let b = right_block(row, place);
            let c = right_block(row, place + 1u);
            let d = right_block(row, place + 2u);
            seen.sums[q][i] = vec4(a.x, b.x, c.x, d.x);
            seen.roots[q][i] = vec4(a.y, b.y, c.y, d.y);
        }
    }
    return seen;
}

fn block_costs(costs: ptr<function, Costs>, sums: ptr<function, Costs>, seen: ptr<function, Seen>, row: u32, x: i32) {
    let left = statistics[row * (2u * frame.width + DISPARITIES - 1u) + u32(x)];
    let entering = right_block(row, frame.width - 1u - u32(x) + (member + 1u) * OWN - 1u);
    for (var q = 0u; q < OWN_QUADS; q++) {
        let last = q + 1u == OWN_QUADS;
        let next = min(q + 1u, OWN_QUADS - 1u);
        let s = moved_down((*seen).sums[q], select((*seen).sums[next][0].x, entering.x, last));
        let r = moved_down((*seen).roots[q], select((*seen).roots[next][0].x, entering.y, last));
        let products = (*sums)[q];
        (*seen).sums[q] = s;
        (*seen).roots[q] = r;
        (*costs)[q] = array(
            correlation_cost(products[0], left, s[0], r[0]), correlation_cost(products[1], left, s[1], r[1]),
            correlation_cost(products[2], left, s[2], r[2]), correlation_cost(products[3], left, s[3], r[3]));
    }
}

fn moved_down(v: array<vec4<u32>, 4>, above: u32) -> array<vec4<u32>, 4> {
    return array(vec4(v[0].yzw, v[1].x), vec4(v[1].yzw, v[2].x), vec4(v[2].yzw, v[3].x), vec4(v[3].yzw, above));
}

// Products modulo 2^32; the covariance itself is below 2^31.
fn correlation_cost(products: vec4<u32>, left: vec2<u32>, right_sums: vec4<u32>, right_roots: vec4<u32>) -> vec4<u32> {
    let covariance = bitcast<vec4<i32>>(BLOCK * BLOCK * products - left.x * right_sums);
    let divisor = max(left.y * right_roots, vec4(1u));
    let size = min(vec4<u32>(abs(covariance)), divisor);
    // floor(4096 size / divisor): the float quotient errs by less than 1/256, so what is 1/64 below is it or one less.
    let quotient = 4096.0 * vec4<f32>(vec4<i32>(size)) / vec4<f32>(vec4<i32>(divisor));
    var part = vec4<u32>(max(quotient - vec4(0.015625), vec4(0.0)));
    part += select(vec4(0u), vec4(1u), 4096u * size - part * divisor >= divisor);
    return select(vec4(4096u) + part, vec4(4096u) - part, covariance >= vec4(0));
}
