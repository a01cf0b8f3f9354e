// mi_table: the cost of a match: 0 for the most mutual information, 255 for the least; |l - r| if all entries are equal.
// joint, marginals (u32, smoothed logarithms), range (i32, the least and the most) -> table (u8, [l][r], four a word)
// One invocation: one word.
// With: mi_shared, common
// Reference: src/reference/cost/mi_table.rs

@group(0) @binding(2) var<storage, read> joint: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> marginals: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> range: array<i32>;
@group(0) @binding(5) var<storage, read_write> table: array<u32>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= 256u * 64u {
        return;
    }
    let l = id.x / 64u;
    let four = id.x % 64u;
    let most = range[1];
    let span = u32(most - range[0]);
    let less = vec4<u32>(vec4(most) - shared_by(l, four, joint[id.x]));
    let costs = (255u * less + vec4(span / 2u)) / vec4(max(span, 1u));
    let apart = vec4<u32>(abs(vec4(i32(l)) - vec4(i32(4u * four)) - vec4(0, 1, 2, 3)));
    table[id.x] = pack(select(costs, apart, vec4(span == 0u)));
}
