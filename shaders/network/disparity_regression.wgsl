// disparity_regression: trilinear interpolation of the scores to four times their sides, softmax over the planes, and the mean of the
//   planes' numbers weighted by it. Neither the large volume nor the softmax is stored.
// values (f32, [plane][row][column][channel], of which the first channel counts) -> result (f32, [row][column])
// One invocation: a pixel.
// Border: the scores at the border go on.
// With: between, image_layer, common
// Chosen: values*
// Reference: src/reference/network/regression.rs

@group(0) @binding(3) var<storage, read_write> result: array<f32>;

// The score of a plane between four of its values.
fn score(plane: u32, x: Between, y: Between) -> f32 {
    let first = dispatch.own.in_at + plane * dispatch.own.in_rows * dispatch.own.in_columns;
    let low = first + y.low * dispatch.own.in_columns;
    let high = first + y.high * dispatch.own.in_columns;
    let upper = mix(value_at(low + x.low).x, value_at(low + x.high).x, x.part);
    let lower = mix(value_at(high + x.low).x, value_at(high + x.high).x, x.part);
    return mix(upper, lower, y.part);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.own.columns {
        return;
    }
    let corners = dispatch.own.rule == 1u;
    let x = between(id.x, dispatch.own.columns, dispatch.own.in_columns, corners);
    let y = between(id.y, dispatch.own.rows, dispatch.own.in_rows, corners);
    let planes = DISPARITIES / 4u;
    // The largest score is subtracted, so that no power overflows, and its disparity, so that sums of few values lose little.
    var largest = 0.0;
    var peak = 0.0;
    var total = 0.0;
    var moment = 0.0;
    for (var round = 0u; round < 2u; round++) {
        var at = 0u;
        var below = score(0u, x, y);
        var above = score(min(1u, planes - 1u), x, y);
        for (var d = 0u; d < DISPARITIES; d++) {
            let z = between(d, DISPARITIES, planes, corners);
            if z.low > at {
                at = z.low;
                below = above;
                above = score(z.high, x, y);
            }
            let value = mix(below, above, z.part);
            if round == 0u {
                let better = d == 0u || value > largest;
                largest = select(largest, value, better);
                peak = select(peak, f32(d), better);
            } else {
                let power = exp(value - largest);
                total += power;
                moment = fma(power, f32(d) - peak, moment);
            }
        }
    }
    result[id.y * dispatch.own.columns + id.x] = peak + moment / total;
}
