// Appended to the kernels of the stage speckle in place of speckle_trees: the trees in four parts of 2^PART_BITS pixels.
@group(0) @binding(3) var<storage, read_write> trees0: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> trees1: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> trees2: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> trees3: array<atomic<u32>>;

const PART_MASK: u32 = (1u << PART_BITS) - 1u;

fn tree_at(pixel: u32) -> u32 {
    switch pixel >> PART_BITS {
        case 0u: {
            return atomicLoad(&trees0[pixel & PART_MASK]);
        }
        case 1u: {
            return atomicLoad(&trees1[pixel & PART_MASK]);
        }
        case 2u: {
            return atomicLoad(&trees2[pixel & PART_MASK]);
        }
        default: {
            return atomicLoad(&trees3[pixel & PART_MASK]);
        }
    }
}

fn set_tree(pixel: u32, value: u32) {
    switch pixel >> PART_BITS {
        case 0u: {
            atomicStore(&trees0[pixel & PART_MASK], value);
        }
        case 1u: {
            atomicStore(&trees1[pixel & PART_MASK], value);
        }
        case 2u: {
            atomicStore(&trees2[pixel & PART_MASK], value);
        }
        default: {
            atomicStore(&trees3[pixel & PART_MASK], value);
        }
    }
}

// Returns the value before.
fn lower_tree(pixel: u32, value: u32) -> u32 {
    switch pixel >> PART_BITS {
        case 0u: {
            return atomicMin(&trees0[pixel & PART_MASK], value);
        }
        case 1u: {
            return atomicMin(&trees1[pixel & PART_MASK], value);
        }
        case 2u: {
            return atomicMin(&trees2[pixel & PART_MASK], value);
        }
        default: {
            return atomicMin(&trees3[pixel & PART_MASK], value);
        }
    }
}

fn add_to_tree(pixel: u32, value: u32) {
    switch pixel >> PART_BITS {
        case 0u: {
            atomicAdd(&trees0[pixel & PART_MASK], value);
        }
        case 1u: {
            atomicAdd(&trees1[pixel & PART_MASK], value);
        }
        case 2u: {
            atomicAdd(&trees2[pixel & PART_MASK], value);
        }
        default: {
            atomicAdd(&trees3[pixel & PART_MASK], value);
        }
    }
}
