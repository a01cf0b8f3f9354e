// Appended to the kernels whose medians are weighted by gray.

// A weight halves with each SIGMA of the difference, linearly in between.
fn weight(difference: u32) -> u32 {
    let halvings = (difference * DECAY) >> 8u;
    return ((512u - (halvings & 255u)) << 6u) >> min(halvings >> 8u, 31u);
}
