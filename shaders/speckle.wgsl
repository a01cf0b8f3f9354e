// speckle: regions of at most speckle_window pixels become invalid; neighbours of a region differ by at most speckle_range.
// map (i16, in a texture), parents and counts (u32, of speckle_count) -> filtered (i16)
// One invocation: four words, eight pixels of a row.
// Reference: src/reference/speckle.rs

@group(0) @binding(3) var<storage, read> parents: array<u32>;
@group(0) @binding(4) var<storage, read> counts: array<u32>;
@group(0) @binding(5) var<storage, read_write> filtered: array<vec4<u32>>;

fn bits(mask: u32, even: vec4<u32>) -> vec4<bool> {
    return (vec4(mask) & even) != vec4(0u);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= frame.height {
        return;
    }
    let p = eight(id.y, id.x);
    let along = joined_along(p);
    let at = id.y * stride + id.x;
    var starts = run_starts(p, along);
    var removed = 0u;
    while starts != 0u {
        let start = min(firstTrailingBit(starts), 7u);
        starts &= starts - 1u;
        let length = 1u + min(firstTrailingBit(~(along >> (start + 1u))), 7u);
        if counts[parents[8u * at + start]] <= frame.speckle_window {
            removed |= ((1u << length) - 1u) << start;
        }
    }
    let even = select(p.even, vec4(INVALID), bits(removed, vec4(1u, 4u, 16u, 64u)));
    let odd = select(p.odd, vec4(INVALID), bits(removed, vec4(2u, 8u, 32u, 128u)));
    filtered[at] = pack_eight(even, odd);
}
