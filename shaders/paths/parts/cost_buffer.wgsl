// Appended to the kernels that read the cost: from the buffer that it was computed into.
@group(0) @binding(2) var<storage, read> cost: array<Stored>;

fn costs_at(slice: u32) -> Slice {
    return slice_of(cost[slice]);
}
