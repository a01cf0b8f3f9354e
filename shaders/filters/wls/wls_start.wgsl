// wls_start: disparity times confidence, and confidence: 1 for a valid pixel, 0 for an invalid one.
// map (i16, in a texture) -> values
// One invocation: four words, eight pixels of a row.
// Border: none.
// With: common
// Reference: src/reference/filters/wls.rs

@group(0) @binding(2) var map: texture_storage_2d<rgba32uint, read>;
// Disparity above the smallest times confidence, and confidence. A row is volume_stride pixels.
@group(0) @binding(3) var<storage, read_write> values: array<vec2<u32>>;

const CERTAIN: u32 = 1u << 30u;

fn value(word: u32, k: u32) -> vec2<u32> {
    let disparity = map_value(word, k);
    return select(vec2(u32(disparity - 16 * frame.min_disparity) << SIXTEENTH_BITS, CERTAIN), vec2(0u), disparity == INVALID);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let index = (dispatch.first_row + id.y) * stride + id.x;
    let words = textureLoad(map, vec2(index % TEXELS, index / TEXELS));
    for (var k = 0u; k < 8u; k++) {
        let x = 8u * id.x + k;
        if x < frame.width {
            values[id.y * frame.volume_stride + x] = value(words[k / 2u], k);
        }
    }
}
