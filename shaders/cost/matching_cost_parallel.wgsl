// matching_cost_parallel: matching_cost for small blocks by as many invocations as possible, without column sums in memory.
// left, right (planes of descriptors) -> cost (u8, [y][x][d], four disparities a word)
// One invocation: sixteen disparities of one column of pixels, SEGMENT rows downwards; the last BLOCK row sums are kept,
//   so that a row leaves the block without being computed again. Neighbouring invocations take the disparities of one
//   pixel, then those of the next pixel, so that they write neighbouring words.
// Border: rows are clamped into the image; the planes continue the columns.
// With: differences, quantise, common
// Chosen: pixel_*
// Reference: src/reference/cost/matching_cost.rs

@group(0) @binding(2) var<storage, read> left: array<u32>;
@group(0) @binding(3) var<storage, read> right: array<u32>;
@group(0) @binding(4) var<storage, read_write> cost: array<vec4<u32>>;

const REACH: u32 = BLOCK - 1u;

// Sums in 16-bit halves of words, as `columns` has them.
alias Sums = array<vec4<u32>, 2>;

fn left_word(row: u32, word: u32) -> u32 {
    return left[row * frame.left_stride + min(word, frame.left_stride - 1u)];
}

fn right_word(row: u32, word: u32) -> u32 {
    return right[row * frame.right_stride + min(word, frame.right_stride - 1u)];
}

// Words of bytes, `shift` bits further on; `next` is the word after them.
fn aligned(words: vec4<u32>, next: u32, shift: u32) -> vec4<u32> {
    return (words >> vec4(shift)) | ((vec4(words.yzw, next) << vec4(1u)) << vec4(31u - shift));
}

// The sums of the costs over a row of the block whose first column is `column`, for the vector q of disparities.
fn row_sums(column: u32, q: u32, row: u32) -> Sums {
    let l = column >> 2u;
    // The right pixels of the last column of the block; a column to the left, they lie one byte further on.
    let j = frame.width - 1u - column + 16u * q;
    let r = j >> 2u;
    let shift = (j & 3u) * 8u;
    var values: Window;
    var window: Window;
    var beyond: Window;
    for (var p = 0u; p < PLANES; p++) {
        let y = p * dispatch.planes_rows + row;
        values[p] = aligned(vec4(left_word(y, l), left_word(y, l + 1u), left_word(y, l + 2u), left_word(y, l + 3u)),
            left_word(y, l + 4u), (column & 3u) * 8u);
        let middle = vec4(right_word(y, r + 4u), right_word(y, r + 5u), right_word(y, r + 6u), right_word(y, r + 7u));
        window[p] = aligned(vec4(right_word(y, r), right_word(y, r + 1u), right_word(y, r + 2u), right_word(y, r + 3u)),
            middle.x, shift);
        beyond[p] = aligned(middle, right_word(y, r + 8u), shift);
    }
    var sums: Sums;
    var bytes = vec4(0u);
    for (var i = 0u; i < BLOCK; i++) {
        let c = REACH - i;
        var pixel = Pixel();
        for (var p = 0u; p < PLANES; p++) {
            pixel[p] = extractBits(values[p][c >> 2u], (c & 3u) * 8u, 8u) * 0x01010101u;
        }
        bytes += pixel_costs(pixel, window);
        if (i + 1u) % SUMMABLE == 0u || i == REACH { // SUMMABLE costs fit a byte
            sums[0] += low_pairs(bytes);
            sums[1] += high_pairs(bytes);
            bytes = vec4(0u);
        }
        for (var p = 0u; p < PLANES; p++) {
            window[p] = (window[p] >> vec4(8u)) | (vec4(window[p].yzw, beyond[p].x) << vec4(24u));
            beyond[p] = (beyond[p] >> vec4(8u)) | (vec4(beyond[p].yzw, 0u) << vec4(24u));
        }
    }
    return sums;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let x = id.x / QUADS;
    let q = id.x % QUADS;
    let begin = id.y * SEGMENT;
    if x >= frame.width || begin >= dispatch.rows {
        return;
    }
    let first = i32(dispatch.first_row + begin) - i32(frame.block_radius);
    let rows = min(SEGMENT, dispatch.rows - begin) + REACH;
    var kept: array<Sums, BLOCK>; // the row sums of the block, the uppermost first
    var sums: Sums;
    for (var n = 0u; n < rows; n++) {
        let row = row_sums(x, q, u32(clamp(first + i32(n), 0, i32(frame.height) - 1)) - dispatch.planes_row);
        for (var part = 0u; part < 2u; part++) {
            sums[part] += row[part] - kept[0][part];
            for (var age = 0u; age < BLOCK; age++) {
                kept[age][part] = kept[min(age + 1u, BLOCK - 1u)][part];
            }
            kept[BLOCK - 1u][part] = row[part];
        }
        if n >= REACH {
            let line = dispatch.volume_row + begin + n - REACH;
            cost[(line * frame.volume_stride + x) * QUADS + q] = quantised_block(sums[0], sums[1]);
        }
    }
}
