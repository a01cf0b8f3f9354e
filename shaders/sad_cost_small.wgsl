// sad_cost_small: sad_cost for blocks of up to 15 pixels on planes that fit a texture, without column sums in memory.
// left, right (prefiltered planes as textures, four pixels a texel) -> cost (u8, [y][x][d], four disparities a word)
// One invocation: two neighbouring rows, from left to right. The right pixels that the disparities are compared with
//   stay in registers and move up by one disparity a step; the last BLOCK column sums are kept, so that a column leaves
//   the block without being computed again.
// Border: rows are clamped into the image, columns by the planes.
// Reference: src/reference/sad_cost.rs

@group(0) @binding(2) var left: texture_storage_2d<r32uint, read>;
@group(0) @binding(3) var right: texture_storage_2d<r32uint, read>;
@group(0) @binding(4) var<storage, read_write> cost: array<vec4<u32>>;

// Rows that the two blocks span.
const ROWS: u32 = BLOCK + 1u;

alias Windows = array<array<vec4<u32>, QUADS>, ROWS>;

// Sums in 16-bit halves of words, as `columns` has them: of the upper block the first two vectors, then of the lower.
alias Sums = array<array<vec4<u32>, 4>, QUADS>;

fn row_at(first: i32, row: u32) -> u32 {
    return u32(clamp(first + i32(row), 0, i32(frame.height) - 1));
}

// Moves every window up by one disparity; byte j of each row of the right plane is the new disparity 0.
fn push(windows: ptr<function, Windows>, first: i32, j: u32) {
    for (var row = 0u; row < ROWS; row++) {
        let word = textureLoad(right, vec2(j >> 2u, row_at(first, row))).x;
        var entering = extractBits(word, (j & 3u) * 8u, 8u);
        for (var q = 0u; q < QUADS; q++) {
            let bytes = (*windows)[row][q];
            (*windows)[row][q] = (bytes << vec4(8u)) | vec4(entering, bytes.xyz >> vec3(24u));
            entering = bytes.w >> 24u;
        }
    }
}

// The absolute differences of sixteen pairs of bytes.
fn differences(a: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
    if SMALL_VALUES == 0u {
        return vec4(differences_of_any(a.x, b.x), differences_of_any(a.x, b.y), differences_of_any(a.x, b.z),
            differences_of_any(a.x, b.w));
    }
    // All bytes are below 128: with the top bit set, no byte borrows from the next. Negative ones are negated.
    let difference = ((a | vec4(0x80808080u)) - b) ^ vec4(0x80808080u);
    let negative = (difference >> vec4(7u)) & vec4(0x01010101u);
    return (difference ^ ((negative << vec4(8u)) - negative)) + negative;
}

fn differences_of_any(a: u32, b: u32) -> u32 {
    return pack(vec4<u32>(abs(vec4<i32>(unpack(a)) - vec4<i32>(unpack(b)))));
}

// The even and the odd bytes as words of 16-bit halves, in the order of `columns`.
fn low_pairs(bytes: vec4<u32>) -> vec4<u32> {
    return vec4(bytes.x, bytes.x >> 8u, bytes.y, bytes.y >> 8u) & vec4(0xff00ffu);
}

fn high_pairs(bytes: vec4<u32>) -> vec4<u32> {
    return vec4(bytes.z, bytes.z >> 8u, bytes.w, bytes.w >> 8u) & vec4(0xff00ffu);
}

fn quantised_block(low: vec4<u32>, high: vec4<u32>) -> vec4<u32> {
    return vec4(quantised(unpack_pairs(low.x, low.y)), quantised(unpack_pairs(low.z, low.w)),
        quantised(unpack_pairs(high.x, high.y)), quantised(unpack_pairs(high.z, high.w)));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = 2u * id.x;
    if row >= pass_.rows {
        return;
    }
    let reach = 2u * frame.block_radius;
    let first = i32(pass_.first_row + row) - i32(frame.block_radius);
    let start = frame.width - 1u + reach;
    var windows: Windows;
    for (var d = 16u * QUADS - 1u; d > 0u; d--) {
        push(&windows, first, start + d);
    }
    var kept: array<Sums, BLOCK>; // the column sums of the block, the oldest first
    var sums: Sums;
    for (var c = 0u; c < frame.width + reach; c++) {
        push(&windows, first, start - c);
        var values: array<vec4<u32>, ROWS>;
        for (var j = 0u; j < ROWS; j++) {
            let word = textureLoad(left, vec2(c >> 2u, row_at(first, j))).x;
            values[j] = vec4(extractBits(word, (c & 3u) * 8u, 8u) * 0x01010101u);
        }
        let x = c - min(c, reach);
        let at = ((pass_.volume_row + row) * frame.width + x) * QUADS;
        for (var q = 0u; q < QUADS; q++) {
            // The rows that both blocks share; SUMMABLE differences fit a byte.
            var low = vec4(0u);
            var high = vec4(0u);
            var bytes = vec4(0u);
            for (var j = 0u; j < ROWS; j++) {
                if j > 0u && j < BLOCK {
                    bytes += differences(values[j], windows[j][q]);
                    if j % SUMMABLE == 0u || j == BLOCK - 1u {
                        low += low_pairs(bytes);
                        high += high_pairs(bytes);
                        bytes = vec4(0u);
                    }
                }
            }
            let top = differences(values[0], windows[0][q]);
            let bottom = differences(values[BLOCK], windows[BLOCK][q]);
            let column = array(low + low_pairs(top), high + high_pairs(top), low + low_pairs(bottom),
                high + high_pairs(bottom));
            for (var part = 0u; part < 4u; part++) {
                sums[q][part] += column[part] - kept[0][q][part];
                for (var age = 0u; age < BLOCK; age++) {
                    kept[age][q][part] = kept[min(age + 1u, BLOCK - 1u)][q][part];
                }
                kept[BLOCK - 1u][q][part] = column[part];
            }
            if c >= reach {
                cost[at + q] = quantised_block(sums[q][0], sums[q][1]);
                if row + 1u < pass_.rows {
                    cost[at + frame.width * QUADS + q] = quantised_block(sums[q][2], sums[q][3]);
                }
            }
        }
    }
}
