// Appended to the kernels that read data terms: those of other levels have 16 bits, two a word: of four disparities the even ones,
// then the odd ones.
@group(0) @binding(2) var<storage, read> terms: array<vec4<u32>>;

fn data_at(slice: u32) -> Data {
    var data: Data;
    for (var w = 0u; w < WIDTH; w++) {
        for (var i = 0u; i < 2u; i++) {
            let words = terms[2u * (slice * WIDTH + w) + i];
            data[w][2u * i] = unpack_pairs(words.x, words.y);
            data[w][2u * i + 1u] = unpack_pairs(words.z, words.w);
        }
    }
    return data;
}
