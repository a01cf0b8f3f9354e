// matching_cost_features: matching_cost of single pixels that are compared by their features.
// left, right (features, bytes with signs, [block of four][row][vector]) -> cost (u8, [y][x][d], four disparities a word)
// One invocation: sixteen disparities of four columns of a row. Neighbouring invocations take the disparities of the same columns.
// Border: columns of the right image are clamped into it.
// With: angles, differences, quantise, common
// Chosen: products_*, beside_*, pixel_census_sobel, pixel_bits
// Reference: src/reference/cost/matching_cost.rs

@group(0) @binding(2) var<storage, read> left: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> right: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> cost: array<vec4<u32>>;

// Four columns of a row of the right features that begins at `start`.
fn right_vector(start: u32, vector: i32, vectors: i32) -> vec4<u32> {
    let words = right[start + u32(clamp(vector, 0, vectors - 1))];
    let before = select(words, vec4(words.x), vec4(vector < 0));
    return select(before, vec4(words.w), vec4(vector >= vectors));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let vectors = (frame.width + 3u) / 4u;
    let vector = id.x / QUADS;
    let q = id.x % QUADS;
    if vector >= vectors || id.y >= dispatch.rows {
        return;
    }
    let row = dispatch.first_row + id.y - dispatch.planes_row;
    // The columns that are seen begin FEATURE_OFFSET columns after this vector's first one.
    let first = (4 * i32(vector) - frame.min_disparity - 16 * i32(q) - 15) >> 2u;
    var sums: array<array<Sum, 16>, 4>;
    for (var block = 0u; block < FEATURES / 4u; block++) {
        let start = (block * dispatch.planes_rows + row) * vectors;
        let own = left[start + vector];
        let pixels = array(four_of(own.x), four_of(own.y), four_of(own.z), four_of(own.w));
        var seen = array<Four, 24>();
        for (var i = 0u; i < 6u; i++) {
            let words = right_vector(start, first + i32(i), i32(vectors));
            seen[4u * i] = four_of(words.x);
            seen[4u * i + 1u] = four_of(words.y);
            seen[4u * i + 2u] = four_of(words.z);
            seen[4u * i + 3u] = four_of(words.w);
        }
        for (var c = 0u; c < 4u; c++) {
            for (var d = 0u; d < 16u; d++) {
                sums[c][d] = plus_products(sums[c][d], pixels[c], seen[FEATURE_OFFSET + 15u - d + c]);
            }
        }
    }
    for (var c = 0u; c < 4u; c++) {
        let x = 4u * vector + c;
        if x < frame.width {
            let costs = with_others(angles(sums[c]), x, q, row);
            cost[((dispatch.volume_row + id.y) * frame.volume_stride + x) * QUADS + q] = quantised_bytes(costs);
        }
    }
}
