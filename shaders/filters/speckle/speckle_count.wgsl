// speckle_count: the pixels of each region, counted at its root until they are more than the window.
// map (i16, in a texture), trees (u32) -> trees (at a root the count; of the first pixel of a run of eight: the root)
// One invocation: eight pixels of a row.
// With: speckle_root, speckle_joins, map_octet, common
// Chosen: speckle_trees, speckle_parts
// Reference: src/reference/filters/speckle.rs

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= frame.height {
        return;
    }
    let p = octet(id.y, id.x);
    let along = joined_along(p);
    let first = 8u * (id.y * stride + id.x);
    var starts = run_starts(p, along);
    while starts != 0u {
        let start = min(firstTrailingBit(starts), 7u);
        starts &= starts - 1u;
        let root = root_of(first + start);
        if root != first + start {
            set_tree(first + start, root);
        }
        // A count only grows: once it exceeds the window, counting can stop.
        if tree_at(root) - ROOT <= frame.speckle_window {
            add_to_tree(root, 1u + firstTrailingBit(~(along >> (start + 1u))));
        }
    }
}
