// Appended to the kernels that compare features: the costs of sixteen sums of products, as bytes.
fn angles(products: array<Sum, 16>) -> vec4<u32> {
    var sums = products;
    var words: array<u32, 4>;
    for (var i = 0u; i < 4u; i++) {
        let four = vec4(i32(sums[4u * i]), i32(sums[4u * i + 1u]), i32(sums[4u * i + 2u]), i32(sums[4u * i + 3u]));
        let rest = vec4<u32>(max(vec4(28900) - four, vec4(0)));
        words[i] = pack(min(rest >> vec4(7u), vec4(225u)));
    }
    return vec4(words[0], words[1], words[2], words[3]);
}
