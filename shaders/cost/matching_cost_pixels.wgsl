// matching_cost_pixels: matching_cost for single pixels, without a block, on planes that fit a texture.
// left, right (planes of descriptors as textures, four pixels a texel) -> cost (u8, [y][x][d], four disparities a word)
// One invocation: sixteen disparities of a row, from left to right, four columns a step. The right pixels that they are
//   compared with stay in registers and move up by four disparities a step. Neighbouring invocations share
//   a pixel.
// Border: the planes continue the columns.
// With: right_bytes, differences, quantise, common
// Chosen: pixel_*
// Reference: src/reference/cost/matching_cost.rs

@group(0) @binding(2) var left: texture_storage_2d<r32uint, read>;
@group(0) @binding(3) var right: texture_storage_2d<r32uint, read>;
@group(0) @binding(4) var<storage, read_write> cost: array<vec4<u32>>;

// The costs of column k of four, whose left bytes are `values`. It sees sixteen right bytes of twenty, from byte 3 - k on:
// `entering` holds the first four.
fn column_costs(k: u32, values: ptr<function, Pixel>, entering: ptr<function, Pixel>, seen: ptr<function, Window>)
    -> vec4<u32> {
    var pixel: Pixel;
    var window: Window;
    let shift = vec4(24u - 8u * k);
    for (var p = 0u; p < PLANES; p++) {
        pixel[p] = (((*values)[p] >> (8u * k)) & 255u) * 0x01010101u;
        let words = (*seen)[p];
        window[p] = (vec4((*entering)[p], words.xyz) >> shift) | ((words << vec4(1u)) << (vec4(31u) - shift));
    }
    return quantised_bytes(pixel_costs(pixel, window));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = id.x / QUADS;
    let q = id.x % QUADS;
    if row >= dispatch.rows {
        return;
    }
    let y = dispatch.first_row - dispatch.planes_row + row; // of the planes
    let start = frame.width - 1u + 16u * q;
    var seen: Window;
    for (var p = 0u; p < PLANES; p++) {
        seen[p] = window(start + 1u, p * dispatch.planes_rows + y);
    }
    for (var x = 0u; x < frame.width; x += 4u) {
        var values = Pixel();
        var entering = Pixel();
        for (var p = 0u; p < PLANES; p++) {
            values[p] = textureLoad(left, vec2(x >> 2u, p * dispatch.planes_rows + y)).x;
            entering[p] = entering_bytes(start - x, p * dispatch.planes_rows + y);
        }
        let at = ((dispatch.volume_row + row) * frame.volume_stride + x) * QUADS + q;
        let inside = frame.width - x;
        let a = column_costs(0u, &values, &entering, &seen);
        let b = column_costs(1u, &values, &entering, &seen);
        let c = column_costs(2u, &values, &entering, &seen);
        let d = column_costs(3u, &values, &entering, &seen);
        cost[at] = a;
        if inside > 1u {
            cost[at + QUADS] = b;
        }
        if inside > 2u {
            cost[at + 2u * QUADS] = c;
        }
        if inside > 3u {
            cost[at + 3u * QUADS] = d;
        }
        for (var p = 0u; p < PLANES; p++) {
            seen[p] = vec4(entering[p], seen[p].xyz);
        }
    }
}
