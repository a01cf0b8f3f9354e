// Appended to the kernels that make or read `columns`, sums of 16 bits: sixteen of a column in two vectors. Of disparities
// 4k .. 4k + 3 word 2k holds the even two and word 2k + 1 the odd two.
alias Sums = array<vec4<u32>, 2>;
const PARTS_OF_SUMS: u32 = 2u;

fn sums_of(pairs: array<vec4<u32>, 2>) -> Sums {
    return Sums(pairs[0], pairs[1]);
}

fn values_of(sums: Sums) -> array<vec4<u32>, 4> {
    return array(unpack_pairs(sums[0].x, sums[0].y), unpack_pairs(sums[0].z, sums[0].w),
        unpack_pairs(sums[1].x, sums[1].y), unpack_pairs(sums[1].z, sums[1].w));
}
