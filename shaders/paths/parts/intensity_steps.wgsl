// Appended to the kernels of the stage `penalties`: P2 of the steps into four pixels.

@group(0) @binding(2) var gray: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(3) var<storage, read_write> penalties: array<vec4<u32>>;

fn gray_at(index: u32) -> vec4<u32> {
    return textureLoad(gray, vec2(index % TEXELS, index / TEXELS));
}

fn penalty(here: vec4<u32>, before: vec4<u32>) -> vec4<u32> {
    let delta = max(abs(vec4<f32>(here) - vec4<f32>(before)), vec4(10.0));
    // A half more keeps the quotient, at most 127, 0.001 away from every whole number: much more than its error.
    let quotient = vec4<u32>(vec4(f32(10u * frame.p2) + 0.5) / delta);
    return min(max(quotient, vec4(frame.p1 + frame.p1 / 2u)), vec4(frame.p2));
}

// Bytes of at most 127: the minimum changes nothing, but keeps LLVM from moving the arithmetic before it into lavapipe's
// store, which is a loop over the lanes (docs/PERFORMANCE.md).
fn stored(words: vec4<u32>) -> vec4<u32> {
    return min(words, vec4(0x7f7f7f7fu));
}
