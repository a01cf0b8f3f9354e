// Appended to the layers: eight texels of weights, each loaded by every invocation.

fn eight_texels(at: u32, lane: u32) -> array<vec4<u32>, 8> {
    var texels: array<vec4<u32>, 8>;
    for (var i = 0u; i < 8u; i++) {
        texels[i] = weights[at + i];
    }
    return texels;
}
