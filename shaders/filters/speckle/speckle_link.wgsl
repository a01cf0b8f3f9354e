// speckle_link: joins the trees of pixels that lie above each other at the border of two bands of rows: the root with the
//   larger number gets a parent with a smaller one. So a region's root is its first pixel, whatever the order.
// map (i16, in a texture), trees (u32) -> trees
// One invocation: eight pixels of the last row of a band, and those below them.
// With: speckle_root, speckle_joins, map_octet, common
// Chosen: speckle_trees, speckle_parts
// Reference: src/reference/filters/speckle.rs

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.lines {
        return;
    }
    let i = dispatch.first_line + id.x;
    let row = dispatch.first_row + id.y * dispatch.row_step;
    let first = 2u * row * frame.map_stride + 8u * i;
    var rest = joined_down(row, i);
    var low = 0u;
    var high = 0u;
    // No pixel is met twice for a pair: the number of rounds is at most that of the two rows' trees and their depths.
    while rest != 0u || low != high {
        if low == high {
            low = first + firstTrailingBit(rest);
            high = low + 2u * frame.map_stride;
            rest &= rest - 1u;
        }
        var parent = tree_at(high);
        if parent >= ROOT {
            parent = lower_tree(high, low);
            // It was a root until now, or another invocation was faster.
            parent = select(parent, low, parent >= ROOT);
        }
        high = max(low, parent);
        low = min(low, parent);
    }
}
