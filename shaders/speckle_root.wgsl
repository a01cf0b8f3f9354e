// Appended to the kernels of the stage speckle that look for roots.
// Reference: src/reference/speckle.rs

fn root_of(pixel: u32) -> u32 {
    var root = pixel;
    var parent = atomicLoad(&parents[root]);
    while parent != root {
        root = parent;
        parent = atomicLoad(&parents[root]);
    }
    return root;
}
