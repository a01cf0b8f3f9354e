// Appended to the kernels that sum products of bytes with signs: as floats, which are exact below 2^24.
alias Sum = f32;
alias Four = vec4<f32>;

fn four_of(word: u32) -> Four {
    return vec4<f32>(unpack4xI8(word));
}

fn plus_products(sum: Sum, a: Four, b: Four) -> Sum {
    return fma(a.w, b.w, fma(a.z, b.z, fma(a.y, b.y, fma(a.x, b.x, sum))));
}
