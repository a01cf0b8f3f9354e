// mi_range: the least and the most mutual information of any two values.
// joint (u32, [l][r]), marginals (u32, of l, then of r): smoothed logarithms -> range (i32, the least, then the most)
// One invocation: the values of one l; the first invocation then compares all. One workgroup.
// With: mi_shared, common
// Reference: src/reference/cost/mi_table.rs

@group(0) @binding(2) var<storage, read> joint: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> marginals: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> range: array<i32>;

var<workgroup> ranges: array<vec2<i32>, 256>;

@compute @workgroup_size(LANES)
fn main(@builtin(local_invocation_id) id: vec3<u32>) {
    var least = vec4(0x7fffffff);
    var most = vec4(-0x7fffffff);
    for (var four = 0u; four < 64u; four++) {
        let values = shared_by(id.x, four, joint[id.x * 64u + four]);
        least = min(least, values);
        most = max(most, values);
    }
    ranges[id.x] = vec2(min(min(least.x, least.y), min(least.z, least.w)), max(max(most.x, most.y), max(most.z, most.w)));
    workgroupBarrier();
    if id.x == 0u {
        var found = ranges[0];
        for (var l = 1u; l < 256u; l++) {
            found = vec2(min(found.x, ranges[l].x), max(found.y, ranges[l].y));
        }
        range[0] = found.x;
        range[1] = found.y;
    }
}
