// Appended to the kernels that send messages: the smallest of values plus a smoothness that grows with the difference, in two passes
// over the disparities.

fn smoothed(values: ptr<function, Costs>, weight: u32) {
    var before = FAR;
    for (var q = 0u; q < OWN_QUADS; q++) {
        for (var i = 0u; i < 4u; i++) {
            var v = (*values)[q][i];
            v.x = min(v.x, before + weight);
            v.y = min(v.y, v.x + weight);
            v.z = min(v.z, v.y + weight);
            v.w = min(v.w, v.z + weight);
            (*values)[q][i] = v;
            before = v.w;
        }
    }
    var after = FAR;
    for (var q = 0u; q < OWN_QUADS; q++) {
        for (var i = 0u; i < 4u; i++) {
            var v = (*values)[OWN_QUADS - 1u - q][3u - i];
            v.w = min(v.w, after + weight);
            v.z = min(v.z, v.w + weight);
            v.y = min(v.y, v.z + weight);
            v.x = min(v.x, v.y + weight);
            (*values)[OWN_QUADS - 1u - q][3u - i] = v;
            after = v.x;
        }
    }
    if MEMBERS > 1u {
        let others = beside(after, before, weight * OWN);
        for (var q = 0u; q < OWN_QUADS; q++) {
            for (var i = 0u; i < 4u; i++) {
                let steps = vec4(16u * q + 4u * i) + vec4(1u, 2u, 3u, 4u);
                let rising = vec4(others.x) + weight * steps;
                let falling = vec4(others.y) + weight * (vec4(OWN + 1u) - steps);
                (*values)[q][i] = min((*values)[q][i], min(rising, falling));
            }
        }
    }
}
