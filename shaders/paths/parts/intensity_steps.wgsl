// Appended to the kernels of the stage `penalties`: P2 of the steps into pixels, or P2 and P1, PENALTY_BYTES a step.

@group(0) @binding(2) var gray: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(3) var<storage, read_write> penalties: array<vec4<u32>>;

fn gray_at(index: u32) -> vec4<u32> {
    return textureLoad(gray, vec2(index % TEXELS, index / TEXELS));
}

// What is stored of the steps into sixteen pixels.
alias Sixteen = array<vec4<u32>, PENALTY_BYTES>;

// P2 of a change of intensity; P2_STEP is 0 where it does not depend on that.
fn large(delta: vec4<f32>) -> vec4<u32> {
    if P2_STEP == 0u {
        return vec4(frame.p2);
    }
    // A half more keeps the quotient, at most 127, 0.001 away from every whole number: much more than its error.
    let quotient = vec4<u32>(vec4(f32(P2_STEP * frame.p2) + 0.5) / max(delta, vec4(f32(P2_STEP))));
    return min(max(quotient, vec4(frame.p1 + frame.p1 / 2u)), vec4(frame.p2));
}

// P1 of it; likewise.
fn small(delta: vec4<f32>) -> vec4<u32> {
    let quotient = vec4<u32>(vec4(f32(3u * frame.p1) + 0.5) / max(delta, vec4(3.0)));
    return min(max(quotient, vec4(8u)), vec4(frame.p1));
}

// The steps into the i-th four pixels, from `before` to `here`; those that come from outside change nothing.
fn put(bytes: ptr<function, Sixteen>, i: u32, here: vec4<u32>, before: vec4<u32>, outside: vec4<bool>) {
    let delta = select(abs(vec4<f32>(here) - vec4<f32>(before)), vec4(0.0), outside);
    if PENALTY_BYTES == 1u {
        (*bytes)[0][i] = pack(large(delta));
    } else {
        let pairs = large(delta) | (small(delta) << vec4(8u));
        let two = pairs.xz | (pairs.yw << vec2(16u));
        (*bytes)[i / 2u][2u * (i % 2u)] = two.x;
        (*bytes)[i / 2u][2u * (i % 2u) + 1u] = two.y;
    }
}

// Bytes of at most 127: the minimum changes nothing, but keeps LLVM from moving the arithmetic before it into lavapipe's
// store, which is a loop over the lanes (docs/PERFORMANCE.md).
fn stored(words: vec4<u32>) -> vec4<u32> {
    return min(words, vec4(0x7f7f7f7fu));
}
