// Appended to the kernels of the stage speckle that look for roots.
// Reference: src/reference/filters/speckle.rs

// A root has this bit and the count of its region; every other pixel has the number of an earlier one.
const ROOT: u32 = 1u << 31u;

fn root_of(pixel: u32) -> u32 {
    var root = pixel;
    var parent = tree_at(root);
    while parent < ROOT {
        root = parent;
        parent = tree_at(root);
    }
    return root;
}
