// Appended to the kernels that slide a block over `columns`: sixteen sums of a column, four a vector.
fn column_at(vector: u32) -> array<vec4<u32>, 4> {
    let low = columns[vector];
    let high = columns[vector + 1u];
    return array(unpack_pairs(low.x, low.y), unpack_pairs(low.z, low.w), unpack_pairs(high.x, high.y),
        unpack_pairs(high.z, high.w));
}
