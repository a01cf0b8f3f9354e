// wls_forward: the first half of the solution along a line: each pixel's mean with those before it.
// gray (u8, of the left image, in a texture), couplings -> values, shares
// carry (the mean and the weight in the rows above) -> carry
// One invocation: a row or a column.
// Border: the first pixel of a line has none before it, the last one none after it.
// With: wls_line, common
// Reference: src/reference/filters/wls.rs

@group(0) @binding(5) var gray: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(6) var<storage, read> couplings: array<u32>;

// The image's rows begin with column -16.
fn gray_at(line: u32, i: u32) -> i32 {
    let along = dispatch.row_step == 0u;
    let x = select(line, i, along) + 16u;
    let y = dispatch.first_row + select(i, line, along);
    let index = y * frame.gray_stride + x / 16u;
    let words = textureLoad(gray, vec2(index % TEXELS, index / TEXELS));
    let two = select(words.xy, words.zw, (x & 8u) != 0u);
    return i32((select(two.x, two.y, (x & 4u) != 0u) >> (8u * (x & 3u))) & 255u);
}

// floor(65536 a / b), of a <= b and a < 65536. A division of floats is off by less than 1, and lavapipe vectorises it,
// unlike a division of integers.
fn quotient(a: u32, b: u32) -> u32 {
    let near = u32(f32(a) / f32(b) * 65536.0);
    let rest = bitcast<i32>((a << 16u) - near * b);
    return near + select(0u, 1u, rest >= i32(b)) - select(0u, 1u, rest < 0);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.lines {
        return;
    }
    let carried = dispatch.carried == 1u;
    var mean = select(vec2(0u), carry[id.x].xy, carried);
    // The weight of the pixels so far, in 1/64.
    var weight = select(64u, carry[id.x].z, carried);
    // The last pixel of the line is coupled to none after it; a batch of rows may end earlier.
    let end = select(frame.height - dispatch.first_row, frame.width, dispatch.row_step == 0u);
    var here = gray_at(id.x, 0u);
    for (var i = 0u; i < dispatch.rows; i++) {
        let at = pixel(id.x, i);
        mean = blend(values[at], mean, quotient(64u, weight));
        let next = gray_at(id.x, min(i + 1u, end - 1u));
        let coupling = select(couplings[dispatch.shift + u32(abs(next - here))], 0u, i + 1u == end);
        let share = quotient(weight, weight + coupling);
        values[at] = mean;
        shares[at] = share;
        weight = 64u + (((65536u - share) * weight) >> 16u);
        here = next;
    }
    carry[id.x] = vec4(mean, weight, 0u);
}
