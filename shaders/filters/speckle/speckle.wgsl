// speckle: regions of at most speckle_window pixels become invalid; neighbours of a region differ by at most speckle_range.
// map (i16, in a texture), trees (u32, of speckle_count) -> filtered (i16)
// One invocation: four words, eight pixels of a row.
// With: speckle_root, speckle_joins, map_octet, common
// Chosen: speckle_trees, speckle_parts
// Reference: src/reference/filters/speckle.rs

@group(0) @binding(FILTERED) var<storage, read_write> filtered: array<vec4<u32>>;

fn bits(mask: u32, even: vec4<u32>) -> vec4<bool> {
    return (vec4(mask) & even) != vec4(0u);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let row = dispatch.first_row + id.y;
    let p = octet(row, id.x);
    let along = joined_along(p);
    let first = 8u * (row * stride + id.x);
    var starts = run_starts(p, along);
    var removed = 0u;
    while starts != 0u {
        let start = min(firstTrailingBit(starts), 7u);
        starts &= starts - 1u;
        let length = 1u + min(firstTrailingBit(~(along >> (start + 1u))), 7u);
        let tree = tree_at(first + start);
        let count = select(tree, tree_at(min(tree, first + start)), tree < ROOT) - ROOT;
        if count <= frame.speckle_window {
            removed |= ((1u << length) - 1u) << start;
        }
    }
    let even = select(p.even, vec4(INVALID), bits(removed, vec4(1u, 4u, 16u, 64u)));
    let odd = select(p.odd, vec4(INVALID), bits(removed, vec4(2u, 8u, 32u, 128u)));
    filtered[id.y * stride + id.x] = pack_octet(even, odd);
}
