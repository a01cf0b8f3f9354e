// speckle_rows: where the run of each pixel starts; a run is what is joined along a row. Clears the counts.
// map (i16, in a texture) -> parents (u32 a pixel, the number of a pixel of its region), counts (u32 a pixel)
// One invocation: a row.
// Reference: src/reference/speckle.rs

@group(0) @binding(3) var<storage, read_write> parents: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> counts: array<vec4<u32>>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.height {
        return;
    }
    let stride = frame.map_stride / 4u;
    var start = 0u;
    for (var i = 0u; i < stride; i++) {
        let along = joined_along(eight(id.x, i));
        let at = id.x * stride + i;
        for (var half = 0u; half < 2u; half++) {
            let first = 8u * at + 4u * half;
            let bits = along >> (4u * half);
            let a = select(first, start, (bits & 1u) != 0u);
            let b = select(first + 1u, a, (bits & 2u) != 0u);
            let c = select(first + 2u, b, (bits & 4u) != 0u);
            start = select(first + 3u, c, (bits & 8u) != 0u);
            parents[2u * at + half] = vec4(a, b, c, start);
            counts[2u * at + half] = vec4(0u);
        }
    }
}
