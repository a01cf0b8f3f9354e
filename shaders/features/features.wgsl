// features: vectors of one length, about 170, of what the last layer left.
// values (i16, two channels a word, [pair of channels][row][vector]) -> result (bytes with signs, four channels a word,
//   [block of four channels][row][vector], of the same rows)
// One invocation: all channels of four columns of a row.
// With: quotients, root, common
// Reference: src/reference/features/features.rs

@group(0) @binding(2) var<storage, read> values: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> result: array<vec4<u32>>;

fn low_half(words: vec4<u32>) -> vec4<i32> {
    return extractBits(bitcast<vec4<i32>>(words), 0u, 16u);
}

fn high_half(words: vec4<u32>) -> vec4<i32> {
    return extractBits(bitcast<vec4<i32>>(words), 16u, 16u);
}

// The low bytes of a channel of four columns, by twice their vectors' lengths.
fn scaled(v: vec4<i32>, lengths: vec4<u32>, doubled: vec4<u32>) -> vec4<u32> {
    let size = min(quotients(340u * vec4<u32>(abs(v)) + lengths, doubled), vec4(127u));
    return select(size, ~size + vec4(1u), v < vec4(0)) & vec4(255u);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let vectors = (frame.width + 3u) / 4u;
    if id.x >= vectors || id.y >= dispatch.rows {
        return;
    }
    let at = id.y * vectors + id.x;
    let stride = dispatch.rows * vectors;
    var squares = vec4(0);
    for (var k = 0u; k < FEATURES / 2u; k++) {
        let words = values[k * stride + at];
        let low = low_half(words);
        let high = high_half(words);
        squares += low * low + high * high;
    }
    let square = vec4<u32>(squares);
    let roots = vec4(integer_root(square.x), integer_root(square.y), integer_root(square.z), integer_root(square.w));
    let lengths = roots + select(vec4(0u), vec4(1u), roots * roots < square);
    // Where the length is 0, all values are.
    let doubled = max(2u * lengths, vec4(1u));
    for (var block = 0u; block < FEATURES / 4u; block++) {
        let first = values[2u * block * stride + at];
        let second = values[(2u * block + 1u) * stride + at];
        result[block * stride + at] = scaled(low_half(first), lengths, doubled)
            | (scaled(high_half(first), lengths, doubled) << vec4(8u))
            | (scaled(low_half(second), lengths, doubled) << vec4(16u))
            | (scaled(high_half(second), lengths, doubled) << vec4(24u));
    }
}
