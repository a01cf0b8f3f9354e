// sad_columns: sums over |j| <= r of |left(x, y + j) - right(x - min_disparity - d, y + j)|.
// left, right (prefiltered planes) -> columns (u16, [y][x + r][d], width + 2 r columns, only the band's rows).
//   Two disparities a word: of disparities 4k .. 4k + 3, word 2k holds the even two and word 2k + 1 the odd two.
// One invocation: one column, SEGMENT rows downwards; a row enters the sum as another leaves it.
// Border: rows are clamped into the image, columns by the planes.
// Reference: src/reference/sad_columns.rs

@group(0) @binding(2) var<storage, read> left: array<u32>;
@group(0) @binding(3) var<storage, read> right: array<u32>;
@group(0) @binding(4) var<storage, read_write> columns: array<vec4<u32>>;

fn clamped_row(y: i32) -> u32 {
    return u32(clamp(y, 0, i32(frame.height) - 1));
}

fn left_at(column: u32, row: u32) -> vec4<i32> {
    return vec4(i32(extractBits(left[row * frame.left_stride + (column >> 2u)], (column & 3u) * 8u, 8u)));
}

// The right pixels that disparities 4 * k .. are compared with, four a word.
fn window(column: u32, row: u32) -> array<u32, WORDS> {
    let j = frame.width - 1u + 2u * frame.block_radius - column;
    let start = row * frame.right_stride + (j >> 2u);
    let shift = (j & 3u) * 8u;
    var words: array<u32, WORDS>;
    var low = right[start];
    for (var q = 0u; q < QUADS; q++) {
        for (var i = 0u; i < 4u; i++) {
            let k = 4u * q + i;
            let high = right[start + k + 1u];
            words[k] = (low >> shift) | ((high << 1u) << (31u - shift));
            low = high;
        }
    }
    return words;
}

fn differences(value: vec4<i32>, word: u32) -> vec4<i32> {
    return abs(value - vec4<i32>(unpack(word)));
}

// Two signed changes of at most 16 bits, added to two sums in a word: carries between the halves cancel.
fn pair(low: i32, high: i32) -> u32 {
    return bitcast<u32>(low) + (bitcast<u32>(high) << 16u);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let column = id.x;
    let count = frame.width + 2u * frame.block_radius;
    let begin = id.y * SEGMENT;
    if column >= count || begin >= pass_.rows {
        return;
    }
    let r = i32(frame.block_radius);
    let y = i32(pass_.first_row + begin);
    var sums: array<u32, PAIRS>;
    for (var j = -r; j <= r; j++) {
        let row = clamped_row(y - 1 + j);
        let value = left_at(column, row);
        let words = window(column, row);
        for (var q = 0u; q < QUADS; q++) {
            for (var i = 0u; i < 4u; i++) {
                let k = 4u * q + i;
                let d = differences(value, words[k]);
                sums[2u * k] += pair(d.x, d.z);
                sums[2u * k + 1u] += pair(d.y, d.w);
            }
        }
    }
    let to = min(begin + SEGMENT, pass_.rows);
    for (var line = begin; line < to; line++) {
        let here = i32(pass_.first_row + line);
        let enters = clamped_row(here + r);
        let leaves = clamped_row(here - 1 - r);
        let value_in = left_at(column, enters);
        let value_out = left_at(column, leaves);
        let words_in = window(column, enters);
        let words_out = window(column, leaves);
        let at = (line * count + column) * 2u * QUADS;
        for (var q = 0u; q < QUADS; q++) {
            for (var i = 0u; i < 4u; i++) {
                let k = 4u * q + i;
                let d = differences(value_in, words_in[k]) - differences(value_out, words_out[k]);
                sums[2u * k] += pair(d.x, d.z);
                sums[2u * k + 1u] += pair(d.y, d.w);
            }
            columns[at + 2u * q] = vec4(sums[8u * q], sums[8u * q + 1u], sums[8u * q + 2u], sums[8u * q + 3u]);
            columns[at + 2u * q + 1u] =
                vec4(sums[8u * q + 4u], sums[8u * q + 5u], sums[8u * q + 6u], sums[8u * q + 7u]);
        }
    }
}
