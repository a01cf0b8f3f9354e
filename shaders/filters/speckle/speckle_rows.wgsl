// speckle_rows: the tree of each run: its first pixel is the root of the others; a run is joined along a row.
// map (i16, in a texture) -> trees (u32 a pixel: of a root 2^31 and a count, else the number of a pixel of its region)
// One invocation: a row.
// With: speckle_joins, map_octet, common
// Reference: src/reference/filters/speckle.rs

@group(0) @binding(3) var<storage, read_write> trees: array<vec4<u32>>;

const ROOT: u32 = 1u << 31u;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.rows {
        return;
    }
    let stride = frame.map_stride / 4u;
    let row = dispatch.first_row + id.x;
    var start = 0u;
    for (var i = 0u; i < stride; i++) {
        let along = joined_along(octet(row, i));
        for (var half = 0u; half < 2u; half++) {
            let first = 8u * (row * stride + i) + 4u * half;
            let joined = (vec4(along >> (4u * half)) & vec4(1u, 2u, 4u, 8u)) != vec4(0u);
            let a = select(first, start, joined.x);
            let b = select(first + 1u, a, joined.y);
            let c = select(first + 2u, b, joined.z);
            let d = select(first + 3u, c, joined.w);
            trees[2u * (id.x * stride + i) + half] = select(vec4(ROOT), vec4(start, a, b, c), joined);
            start = d;
        }
    }
}
