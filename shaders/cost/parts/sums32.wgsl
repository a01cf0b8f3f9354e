// Appended to the kernels that make or read `columns`, sums of 32 bits: sixteen of a column in four vectors, in order.
alias Sums = array<vec4<u32>, 4>;
const PARTS_OF_SUMS: u32 = 4u;

fn sums_of(pairs: array<vec4<u32>, 2>) -> Sums {
    return Sums(unpack_pairs(pairs[0].x, pairs[0].y), unpack_pairs(pairs[0].z, pairs[0].w),
        unpack_pairs(pairs[1].x, pairs[1].y), unpack_pairs(pairs[1].z, pairs[1].w));
}

fn values_of(sums: Sums) -> array<vec4<u32>, 4> {
    return array(sums[0], sums[1], sums[2], sums[3]);
}
