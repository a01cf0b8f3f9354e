// Appended to the kernels that read data terms: those of the full size are the cost.

fn data_at(slice: u32) -> Data {
    let packed = costs_at(slice);
    var data: Data;
    for (var w = 0u; w < WIDTH; w++) {
        data[w] = pairs_of(packed[w]);
    }
    return data;
}
