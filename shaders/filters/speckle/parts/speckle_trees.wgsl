// Appended to the kernels of the stage speckle where the trees fit one binding.
@group(0) @binding(3) var<storage, read_write> trees: array<atomic<u32>>;

fn tree_at(pixel: u32) -> u32 {
    return atomicLoad(&trees[pixel]);
}

fn set_tree(pixel: u32, value: u32) {
    atomicStore(&trees[pixel], value);
}

// Returns the value before.
fn lower_tree(pixel: u32, value: u32) -> u32 {
    return atomicMin(&trees[pixel], value);
}

fn add_to_tree(pixel: u32, value: u32) {
    atomicAdd(&trees[pixel], value);
}
