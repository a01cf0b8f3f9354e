// Appended to the two kernels of the stage wls that walk lines.

// Disparity above the smallest times confidence, and confidence.
@group(0) @binding(2) var<storage, read_write> values: array<vec2<u32>>;
// The weight, of 65536, of the mean with the pixels before in the solution; the rest is the weight of the pixel after.
@group(0) @binding(3) var<storage, read_write> shares: array<u32>;

// share / 65536 of a and the rest of b, to the nearest number, a half upwards.
fn blend(a: vec2<u32>, b: vec2<u32>, share: u32) -> vec2<u32> {
    let rest = 65536u - share;
    let low = (a & vec2(0xffffu)) * share + (b & vec2(0xffffu)) * rest + 32768u;
    return (a >> vec2(16u)) * share + (b >> vec2(16u)) * rest + (low >> vec2(16u));
}

// Of each line, from one batch of rows to the next: the mean, and the weight that belongs to it.
@group(0) @binding(4) var<storage, read_write> carry: array<vec4<u32>>;

// A line's pixels lie dispatch.dx apart, the first ones of neighbouring lines dispatch.dy.
fn pixel(line: u32, i: u32) -> u32 {
    return line * u32(dispatch.dy) + i * u32(dispatch.dx);
}
