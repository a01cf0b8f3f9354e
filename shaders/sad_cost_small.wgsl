// sad_cost_small: sad_cost for blocks of up to 15 pixels on planes that fit a texture, without column sums in memory.
// left, right (prefiltered planes as textures, four pixels a texel) -> cost (u8, [y][x][d], four disparities a word)
// One invocation: sixteen disparities of two neighbouring rows, from left to right. The right pixels that they are
//   compared with stay in registers and move up by one disparity a step; the last BLOCK column sums are kept, so that a
//   column leaves the block without being computed again. Neighbouring invocations: the disparities of one pixel.
// Border: rows are clamped into the image, columns by the planes.
// Reference: src/reference/sad_cost.rs

@group(0) @binding(2) var left: texture_storage_2d<r32uint, read>;
@group(0) @binding(3) var right: texture_storage_2d<r32uint, read>;
@group(0) @binding(4) var<storage, read_write> cost: array<vec4<u32>>;

// Rows that the two blocks span.
const ROWS: u32 = BLOCK + 1u;

// Sums in 16-bit halves of words, as `columns` has them: of the upper block the first two vectors, then of the lower.
alias Sums = array<vec4<u32>, 4>;

fn row_at(first: i32, row: u32) -> u32 {
    return u32(clamp(first + i32(row), 0, i32(frame.height) - 1));
}

fn right_word(word: u32, y: u32) -> u32 {
    return textureLoad(right, vec2(min(word, frame.right_stride - 1u), y)).x;
}

// Sixteen bytes of the right plane, from byte j on.
fn window(j: u32, y: u32) -> vec4<u32> {
    let at = j >> 2u;
    let shift = (j & 3u) * 8u;
    let words = vec4(right_word(at, y), right_word(at + 1u, y), right_word(at + 2u, y), right_word(at + 3u, y));
    let next = vec4(words.yzw, right_word(at + 4u, y));
    return (words >> vec4(shift)) | ((next << vec4(1u)) << vec4(31u - shift));
}

// Four bytes of the right plane, from byte j - 3 to byte j. Those before byte 0 are of no meaning.
fn entering_bytes(j: u32, y: u32) -> u32 {
    let shift = (j & 3u) * 8u;
    let before = right_word(max(j >> 2u, 1u) - 1u, y);
    return (right_word(j >> 2u, y) << (24u - shift)) | ((before >> 8u) >> shift);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = 2u * (id.x / QUADS);
    let q = id.x % QUADS;
    if row >= pass_.rows {
        return;
    }
    let reach = 2u * frame.block_radius;
    let first = i32(pass_.first_row + row) - i32(frame.block_radius);
    let start = frame.width - 1u + reach + 16u * q;
    let columns = frame.width + reach;
    var windows: array<vec4<u32>, ROWS>;
    for (var j = 0u; j < ROWS; j++) {
        windows[j] = window(start + 1u, row_at(first, j));
    }
    var kept: array<Sums, BLOCK>; // the column sums of the block, the oldest first
    var sums: Sums;
    for (var four = 0u; four < columns; four += 4u) {
        // The pixels of four columns: of the left plane the first in the lowest byte, of the right one in the highest.
        var values: array<u32, ROWS>;
        var entering: array<u32, ROWS>;
        for (var j = 0u; j < ROWS; j++) {
            values[j] = textureLoad(left, vec2(four >> 2u, row_at(first, j))).x;
            entering[j] = entering_bytes(start - four, row_at(first, j));
        }
        // Beyond the last column it is computed, but not written: leaving early costs a copy of all that lives.
        for (var c = four; c < four + 4u; c++) {
            // The rows that both blocks share; SUMMABLE differences fit a byte.
            var low = vec4(0u);
            var high = vec4(0u);
            var bytes = vec4(0u);
            var top = vec4(0u);
            var bottom = vec4(0u);
            for (var j = 0u; j < ROWS; j++) {
                windows[j] = (windows[j] << vec4(8u)) | vec4(entering[j] >> 24u, windows[j].xyz >> vec3(24u));
                let difference = differences((values[j] & 255u) * 0x01010101u, windows[j]);
                entering[j] <<= 8u;
                values[j] >>= 8u;
                if j == 0u {
                    top = difference;
                } else if j == BLOCK {
                    bottom = difference;
                } else {
                    bytes += difference;
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
                let at = ((pass_.volume_row + row) * frame.volume_stride + c - reach) * QUADS + q;
                cost[at] = quantised_block(sums[0], sums[1]);
                if row + 1u < pass_.rows {
                    cost[at + frame.volume_stride * QUADS] = quantised_block(sums[2], sums[3]);
                }
            }
        }
    }
}
