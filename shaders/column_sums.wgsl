// Appended to the kernels that slide a block over `columns`: one column enters the sums, or leaves them.
fn enter(sums: ptr<function, Costs>, at: u32) {
    for (var q = 0u; q < OWN_QUADS; q++) {
        if in_volume(q) {
            let low = columns[at + 2u * (member * OWN_QUADS + q)];
            let high = columns[at + 2u * (member * OWN_QUADS + q) + 1u];
            (*sums)[q][0] += unpack_pairs(low.x, low.y);
            (*sums)[q][1] += unpack_pairs(low.z, low.w);
            (*sums)[q][2] += unpack_pairs(high.x, high.y);
            (*sums)[q][3] += unpack_pairs(high.z, high.w);
        }
    }
}

fn leave(sums: ptr<function, Costs>, at: u32) {
    for (var q = 0u; q < OWN_QUADS; q++) {
        if in_volume(q) {
            let low = columns[at + 2u * (member * OWN_QUADS + q)];
            let high = columns[at + 2u * (member * OWN_QUADS + q) + 1u];
            (*sums)[q][0] -= unpack_pairs(low.x, low.y);
            (*sums)[q][1] -= unpack_pairs(low.z, low.w);
            (*sums)[q][2] -= unpack_pairs(high.x, high.y);
            (*sums)[q][3] -= unpack_pairs(high.z, high.w);
        }
    }
}
