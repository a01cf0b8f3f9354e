// Appended to the kernels that slide a block over `columns`: sixteen sums of a column, four a vector. The columns of a
// pixel's disparities are PARTS_OF_SUMS vectors for each sixteen of them.
fn column_at(sixteen: u32) -> array<vec4<u32>, 4> {
    var sums: Sums;
    for (var part = 0u; part < PARTS_OF_SUMS; part++) {
        sums[part] = columns[sixteen * PARTS_OF_SUMS + part];
    }
    return values_of(sums);
}
