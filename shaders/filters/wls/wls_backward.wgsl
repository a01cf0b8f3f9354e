// wls_backward: the second half of the solution along a line: each pixel's mean with those after it.
// values, shares, carry (the mean in the rows below) -> values, carry
// One invocation: a row or a column, from its end.
// Border: the last pixel of a line keeps its value.
// With: wls_line, common
// Reference: src/reference/filters/wls.rs

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.lines {
        return;
    }
    var mean = select(vec2(0u), carry[id.x].xy, dispatch.carried == 1u);
    for (var i = 0u; i < dispatch.rows; i++) {
        let at = pixel(id.x, dispatch.rows - 1u - i);
        mean = blend(values[at], mean, shares[at]);
        values[at] = mean;
    }
    carry[id.x] = vec4(mean, 0u, 0u);
}
