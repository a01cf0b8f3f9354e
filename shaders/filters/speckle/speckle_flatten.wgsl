// speckle_flatten: after speckle_link, all pixels on the ways from the border's pixels to a root get it as their parent.
//   So a tree is one deeper after each border at most.
// map (i16, in a texture), trees (u32) -> trees
// One invocation: as in speckle_link.
// With: speckle_root, speckle_joins, map_octet, common
// Chosen: speckle_trees, speckle_parts
// Reference: src/reference/filters/speckle.rs

fn flatten(pixel: u32, root: u32) {
    var at = pixel;
    while at != root {
        let parent = tree_at(at);
        if parent != root {
            set_tree(at, root);
        }
        at = parent;
    }
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.lines {
        return;
    }
    let i = dispatch.first_line + id.x;
    let row = dispatch.first_row + id.y * dispatch.row_step;
    let first = 2u * row * frame.map_stride + 8u * i;
    var rest = joined_down(row, i);
    while rest != 0u {
        let pixel = first + firstTrailingBit(rest);
        rest &= rest - 1u;
        let root = root_of(pixel);
        flatten(pixel, root);
        flatten(pixel + 2u * frame.map_stride, root);
    }
}
