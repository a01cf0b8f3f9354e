// sad_columns: sums over |j| <= r of |left(x, y + j) - right(x - min_disparity - d, y + j)|.
// left, right (prefiltered planes) -> columns (u16, [y][x + r][d], width + 2 r columns, only the band's rows).
//   Two disparities a word: of disparities 4k .. 4k + 3, word 2k holds the even two and word 2k + 1 the odd two.
// One invocation: sixteen disparities of one column, SEGMENT rows downwards; a row enters the sum as another leaves it.
//   Neighbouring invocations: the disparities of one column, then the next column.
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

// The right pixels that the vector q of disparities is compared with, four a word.
fn window(column: u32, q: u32, row: u32) -> vec4<u32> {
    let j = frame.width - 1u + 2u * frame.block_radius - column;
    let at = row * frame.right_stride + (j >> 2u) + 4u * q;
    let shift = (j & 3u) * 8u;
    let words = vec4(right[at], right[at + 1u], right[at + 2u], right[at + 3u]);
    return (words >> vec4(shift)) | ((vec4(words.yzw, right[at + 4u]) << vec4(1u)) << vec4(31u - shift));
}

fn differences(value: vec4<i32>, word: u32) -> vec4<i32> {
    return abs(value - vec4<i32>(unpack(word)));
}

// Two signed changes of at most 16 bits, added to two sums in a word: carries between the halves cancel.
fn pair(low: i32, high: i32) -> u32 {
    return bitcast<u32>(low) + (bitcast<u32>(high) << 16u);
}

// Adds sixteen changes to sixteen sums.
fn add(sums: ptr<function, array<vec4<u32>, 2>>, a: vec4<i32>, b: vec4<i32>, c: vec4<i32>, d: vec4<i32>) {
    (*sums)[0] += vec4(pair(a.x, a.z), pair(a.y, a.w), pair(b.x, b.z), pair(b.y, b.w));
    (*sums)[1] += vec4(pair(c.x, c.z), pair(c.y, c.w), pair(d.x, d.z), pair(d.y, d.w));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let column = id.x / QUADS;
    let q = id.x % QUADS;
    let count = frame.width + 2u * frame.block_radius;
    let begin = id.y * SEGMENT;
    if column >= count || begin >= pass_.rows {
        return;
    }
    let r = i32(frame.block_radius);
    let y = i32(pass_.first_row + begin);
    var sums: array<vec4<u32>, 2>;
    for (var j = -r; j <= r; j++) {
        let row = clamped_row(y - 1 + j);
        let value = left_at(column, row);
        let words = window(column, q, row);
        add(&sums, differences(value, words.x), differences(value, words.y), differences(value, words.z),
            differences(value, words.w));
    }
    let to = min(begin + SEGMENT, pass_.rows);
    for (var line = begin; line < to; line++) {
        let here = i32(pass_.first_row + line);
        let enters = clamped_row(here + r);
        let leaves = clamped_row(here - 1 - r);
        let a = left_at(column, enters);
        let b = left_at(column, leaves);
        let words_a = window(column, q, enters);
        let words_b = window(column, q, leaves);
        add(&sums, differences(a, words_a.x) - differences(b, words_b.x), differences(a, words_a.y) - differences(b, words_b.y),
            differences(a, words_a.z) - differences(b, words_b.z), differences(a, words_a.w) - differences(b, words_b.w));
        let at = ((line * count + column) * QUADS + q) * 2u;
        columns[at] = sums[0];
        columns[at + 1u] = sums[1];
    }
}
