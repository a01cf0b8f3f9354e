// Appended to the layers of a network of features: what they know of their layer, where values lie, and what becomes of sums.
// Values: four columns a vector, four channels a word of it, a byte with a sign each, the lowest channel first:
// [block of four channels][row][vector]. Columns beyond the border repeat it.

struct Own {
    in_first: u32,     // the row of the image that the values which are read begin with
    in_rows: u32,      // rows of them
    in_blocks: u32,    // blocks of four channels that are read
    out_blocks: u32,   // and that are left
    weights: u32,      // the first texel of the layer's weights
    lowest: i32,       // what results are clamped to
    highest: i32,
    wide: u32,         // 1: results of 16 bits are left, two channels a word, two blocks of them for each of four channels
}

@group(0) @binding(2) var<storage, read> values: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> weights: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> result: array<vec4<u32>>;

fn row_vectors() -> u32 {
    return (frame.width + 3u) / 4u;
}

// The sums of four channels as values.
fn requantised(sums: vec4<i32>, multipliers: vec4<u32>, shifts: vec4<u32>) -> vec4<i32> {
    let shift = shifts & vec4(31u);
    let rounding = vec4<i32>((vec4(1u) << shift) >> vec4(1u));
    let shifted = (sums * vec4<i32>(multipliers) + rounding) >> shift;
    return clamp(shifted, vec4(dispatch.own.lowest), vec4(dispatch.own.highest));
}

// Leaves four channels of four columns.
fn leave(block: u32, row: u32, vector: u32, columns: array<vec4<i32>, 4>) {
    var kept = columns;
    let last = frame.width - 1u - 4u * vector;
    for (var c = 1u; c < 4u; c++) {
        kept[c] = select(kept[c], kept[c - 1u], vec4(c > last));
    }
    let stride = dispatch.rows * row_vectors();
    let at = row * row_vectors() + vector;
    if dispatch.own.wide == 1u {
        let first = 2u * block * stride + at;
        result[first] = vec4(pair(kept[0].xy), pair(kept[1].xy), pair(kept[2].xy), pair(kept[3].xy));
        result[first + stride] = vec4(pair(kept[0].zw), pair(kept[1].zw), pair(kept[2].zw), pair(kept[3].zw));
    } else {
        result[block * stride + at] = vec4(packed_bytes(kept[0]), packed_bytes(kept[1]), packed_bytes(kept[2]), packed_bytes(kept[3]));
    }
}

fn pair(v: vec2<i32>) -> u32 {
    return (bitcast<u32>(v.x) & 0xffffu) | (bitcast<u32>(v.y) << 16u);
}

fn packed_bytes(v: vec4<i32>) -> u32 {
    return pack(bitcast<vec4<u32>>(v) & vec4(255u));
}
