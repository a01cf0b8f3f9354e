// Appended to the kernels that read data terms: those of other levels have 16 bits, two a word: of four disparities the even ones,
// then the odd ones.
@group(0) @binding(2) var<storage, read> terms: array<vec4<u32>>;

fn data_at(slice: u32) -> Data {
    var data: Data;
    for (var w = 0u; w < WIDTH; w++) {
        let low = terms[2u * (slice * WIDTH + w)];
        let high = terms[2u * (slice * WIDTH + w) + 1u];
        data[w] = Pairs(vec4(low.xz, high.xz), vec4(low.yw, high.yw));
    }
    return data;
}
