// Appended to the kernels of the stage `penalties`: P2 of the steps into sixteen pixels of a row.

@group(0) @binding(2) var gray: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(3) var<storage, read_write> penalties: array<vec4<u32>>;

// Of sixteen pixels of a row the words with the pixels before and after them.
alias Pixels = array<u32, 6>;

fn gray_at(index: u32) -> vec4<u32> {
    return textureLoad(gray, vec2(index % TEXELS, index / TEXELS));
}

fn pixels_at(vector: u32, y: u32) -> Pixels {
    let at = y * frame.gray_stride + vector + 1u; // the first vector lies before the image
    let here = gray_at(at);
    return Pixels(gray_at(at - 1u).w, here.x, here.y, here.z, here.w, gray_at(at + 1u).x);
}

// Four neighbours of the pixels of word i, dx columns to the left of them.
fn neighbours(pixels: Pixels, i: u32, dx: i32) -> vec4<u32> {
    let here = pixels[i + 1u];
    if dx > 0 {
        let shift = 8u * u32(dx);
        return unpack((here << shift) | (pixels[i] >> (32u - shift)));
    }
    if dx < 0 {
        let shift = 8u * u32(-dx);
        return unpack((here >> shift) | (pixels[i + 2u] << (32u - shift)));
    }
    return unpack(here);
}

fn penalty(here: vec4<u32>, before: vec4<u32>) -> vec4<u32> {
    let delta = max(abs(vec4<i32>(here) - vec4<i32>(before)), vec4(10));
    // A half more keeps the quotient, at most 127, 0.001 away from every whole number: much more than its error.
    let quotient = vec4<i32>(vec4(f32(10u * frame.p2) + 0.5) / vec4<f32>(delta));
    return min(max(vec4<u32>(quotient), vec4(frame.p1 + frame.p1 / 2u)), vec4(frame.p2));
}
