// mi_marginals: the sums of the rows of a table of 256 x 256 entries, then those of its columns.
// joint (u32, [l][r]) -> marginals (u32, of 256 values l, then of 256 values r)
// One invocation: one sum.
// With: common
// Reference: src/reference/cost/mi_table.rs

@group(0) @binding(2) var<storage, read> joint: array<u32>;
@group(0) @binding(3) var<storage, read_write> marginals: array<u32>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= 512u {
        return;
    }
    let value = id.x % 256u;
    let start = select(value, value * 256u, id.x < 256u);
    let stride = select(256u, 1u, id.x < 256u);
    var sum = 0u;
    for (var i = 0u; i < 256u; i++) {
        sum += joint[start + i * stride];
    }
    marginals[id.x] = sum;
}
