// matching_cost_small: matching_cost for small blocks on planes that fit a texture, without column sums in memory.
// left, right (planes of descriptors as textures, four pixels a texel) -> cost (u8, [y][x][d], four disparities a word)
// One invocation: sixteen disparities of two neighbouring rows, from left to right. The right pixels that they are
//   compared with stay in registers and move up by one disparity a step; the last BLOCK column sums are kept, so that a
//   column leaves the block without being computed again. Neighbouring invocations share a pixel.
// Border: rows are clamped into the image; the planes continue the columns.
// With: right_bytes, differences, quantise, common
// Chosen: pixel_*
// Reference: src/reference/cost/matching_cost.rs

@group(0) @binding(2) var left: texture_storage_2d<r32uint, read>;
@group(0) @binding(3) var right: texture_storage_2d<r32uint, read>;
@group(0) @binding(4) var<storage, read_write> cost: array<vec4<u32>>;

// Rows that the two blocks span.
const ROWS: u32 = BLOCK + 1u;

// Sums in 16-bit halves of words, as `columns` has them: of the upper block the first two vectors, then of the lower.
alias Sums = array<vec4<u32>, 4>;

// Of the planes.
fn row_at(first: i32, row: u32) -> u32 {
    return u32(clamp(first + i32(row), 0, i32(frame.height) - 1)) - dispatch.planes_row;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = 2u * (id.x / QUADS);
    let q = id.x % QUADS;
    if row >= dispatch.rows {
        return;
    }
    let reach = 2u * frame.block_radius;
    let first = i32(dispatch.first_row + row) - i32(frame.block_radius);
    let start = frame.width - 1u + reach + 16u * q;
    let columns = frame.width + reach;
    var windows: array<Window, ROWS>;
    for (var j = 0u; j < ROWS; j++) {
        for (var p = 0u; p < PLANES; p++) {
            windows[j][p] = window(start + 1u, p * dispatch.planes_rows + row_at(first, j));
        }
    }
    var kept: array<Sums, BLOCK>; // the column sums of the block, the oldest first
    var sums: Sums;
    for (var four = 0u; four < columns; four += 4u) {
        // The pixels of four columns: of the left plane the first in the lowest byte, of the right one in the highest.
        var values = array<Pixel, ROWS>();
        var entering = array<Pixel, ROWS>();
        for (var j = 0u; j < ROWS; j++) {
            for (var p = 0u; p < PLANES; p++) {
                let plane_row = p * dispatch.planes_rows + row_at(first, j);
                values[j][p] = textureLoad(left, vec2(four >> 2u, plane_row)).x;
                entering[j][p] = entering_bytes(start - four, plane_row);
            }
        }
        // Beyond the last column it is computed, but not written: returning early costs a copy of all live values.
        for (var c = four; c < four + 4u; c++) {
            // The rows that both blocks share; SUMMABLE costs fit a byte.
            var low = vec4(0u);
            var high = vec4(0u);
            var bytes = vec4(0u);
            var top = vec4(0u);
            var bottom = vec4(0u);
            for (var j = 0u; j < ROWS; j++) {
                var pixel = Pixel();
                for (var p = 0u; p < PLANES; p++) {
                    let words = windows[j][p];
                    windows[j][p] = (words << vec4(8u)) | vec4(entering[j][p] >> 24u, words.xyz >> vec3(24u));
                    pixel[p] = (values[j][p] & 255u) * 0x01010101u;
                    entering[j][p] <<= 8u;
                    values[j][p] >>= 8u;
                }
                let costs = pixel_costs(pixel, windows[j]);
                if j == 0u {
                    top = costs;
                } else if j == BLOCK {
                    bottom = costs;
                } else {
                    bytes += costs;
                    if j % SUMMABLE == 0u || j == BLOCK - 1u {
                        low += low_pairs(bytes);
                        high += high_pairs(bytes);
                        bytes = vec4(0u);
                    }
                }
            }
            let column = Sums(low + low_pairs(top), high + high_pairs(top), low + low_pairs(bottom),
                high + high_pairs(bottom));
            for (var part = 0u; part < 4u; part++) {
                sums[part] += column[part] - kept[0][part];
                for (var age = 0u; age < BLOCK; age++) {
                    kept[age][part] = kept[min(age + 1u, BLOCK - 1u)][part];
                }
                kept[BLOCK - 1u][part] = column[part];
            }
            if c >= reach && c < columns {
                let at = ((dispatch.volume_row + row) * frame.volume_stride + c - reach) * QUADS + q;
                cost[at] = quantised_block(sums[0], sums[1]);
                if row + 1u < dispatch.rows {
                    cost[at + frame.volume_stride * QUADS] = quantised_block(sums[2], sums[3]);
                }
            }
        }
    }
}
