// weighted_median: the weighted median of 25 values around a pixel, SPACING rows and columns apart; a weight falls with the
//   difference of its pixel from the middle one in gray.
// map (i16, in a texture), gray (u8, of the left image, in a texture) -> filtered (i16)
// One invocation: four words, eight pixels of a row.
// Border: pixels outside the image and invalid ones have no weight; an invalid pixel stays invalid.
// With: weighted_keys, gray_weight, gray_octet, map_octet, common
// Reference: src/reference/filters/weighted_median.rs

@group(0) @binding(3) var<storage, read_write> filtered: array<vec4<u32>>;

// Vectors of eight pixels that are read on either side, and with the one between.
const AROUND: u32 = (2u * SPACING + 7u) / 8u;
const EIGHTS: u32 = 2u * AROUND + 1u;

// Eight pixels of the map, from column x on; arbitrary where they lie outside.
fn inside(words: vec4<u32>, x: i32) -> vec4<u32> {
    let even = vec4(0, 2, 4, 6) + vec4(x);
    let width = vec4(i32(frame.width));
    let low = select(vec4(0u), vec4(0xffffu), (even >= vec4(0)) & (even < width));
    let high = select(vec4(0u), vec4(0xffff0000u), (even >= vec4(0)) & (even < width - vec4(1)));
    return (words ^ vec4(NOTHING)) & (low | high);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    var values: array<array<vec4<u32>, EIGHTS>, 5>;
    var grays: array<array<vec2<u32>, EIGHTS>, 5>;
    for (var j = 0u; j < 5u; j++) {
        let y = i32(dispatch.first_row + id.y + j * SPACING) - i32(2u * SPACING);
        let row = u32(clamp(y, 0, i32(frame.height) - 1));
        // All columns of a row outside lie outside.
        let off = select(i32(frame.width + 8u * AROUND), 0, y == i32(row));
        for (var e = 0u; e < EIGHTS; e++) {
            let i = i32(id.x + e) - i32(AROUND);
            let words = map_at(row * stride + u32(clamp(i, 0, i32(stride) - 1)));
            values[j][e] = inside(words, 8 * i + off);
            grays[j][e] = gray_words(row, u32(i + 2));
        }
    }
    var results: array<u32, 8>;
    for (var k = 0u; k < 8u; k++) {
        let here = extractBits(grays[2][AROUND][k / 4u], (k % 4u) * 8u, 8u);
        let valid = extractBits(values[2][AROUND][k / 2u], (k % 2u) * 16u, 16u) != 0u;
        var keys = array<u32, 25>();
        for (var n = 0u; n < 25u; n++) {
            let at = 8u * AROUND + k + n % 5u * SPACING - 2u * SPACING;
            let value = extractBits(values[n / 5u][at / 8u][at / 2u % 4u], (at % 2u) * 16u, 16u);
            let there = extractBits(grays[n / 5u][at / 8u][at / 4u % 2u], (at % 4u) * 8u, 8u);
            let difference = max(here, there) - min(here, there);
            keys[n] = (value << 16u) | select(weight(difference), 0u, value == 0u);
        }
        sort(&keys);
        results[k] = select(0u, middle(&keys), valid);
    }
    filtered[id.y * stride + id.x] = vec4(NOTHING) ^ vec4(
        results[0] | (results[1] << 16u), results[2] | (results[3] << 16u),
        results[4] | (results[5] << 16u), results[6] | (results[7] << 16u));
}
