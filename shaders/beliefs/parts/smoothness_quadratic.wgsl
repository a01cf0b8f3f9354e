// Appended to the kernels that send messages: the smallest of values plus a smoothness that grows with the square of the difference.
// k steps of 1, 3, 5 .. weights make k^2 of them, so that as many passes as a message has steps do, each over neighbours.

fn smoothed(values: ptr<function, Costs>, weight: u32) {
    for (var k = 0u; k < QUADRATIC_STEPS; k++) {
        let step = min((2u * k + 1u) * weight, 255u);
        let around = exchange(0u, (*values)[0][0].x, (*values)[OWN_QUADS - 1u][3].w);
        var below = around.below;
        for (var q = 0u; q < OWN_QUADS; q++) {
            let after = select((*values)[min(q + 1u, OWN_QUADS - 1u)][0].x, around.above, q + 1u == OWN_QUADS);
            for (var i = 0u; i < 4u; i++) {
                let v = (*values)[q][i];
                let next = select((*values)[q][min(i + 1u, 3u)].x, after, i == 3u);
                (*values)[q][i] = min(v, min(vec4(below, v.xyz), vec4(v.yzw, next)) + vec4(step));
                below = v.w;
            }
        }
    }
    if weight == 0u {
        for (var q = 0u; q < OWN_QUADS; q++) {
            (*values)[q] = array(vec4(0u), vec4(0u), vec4(0u), vec4(0u));
        }
    }
}
