// sad_columns: sums over |j| <= r of |left(x, y + j) - right(x - min_disparity - d, y + j)|.
// left, right (prefiltered planes) -> columns (u16, [y][x + r][d], width + 2 r columns, only the band's rows).
//   Two disparities a word: of disparities 4k .. 4k + 3, word 2k holds the even two and word 2k + 1 the odd two.
// One invocation: VECTORS x 16 disparities of one column, SEGMENT rows downwards; a row enters the sum as another leaves
//   it. Neighbouring invocations: the disparities of one column, then the next column.
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

alias Sums = array<array<vec4<u32>, 2>, VECTORS>;

// The right pixels that the disparities are compared with, from vector q of them on, four a word.
fn window(column: u32, q: u32, row: u32) -> array<vec4<u32>, VECTORS> {
    let j = frame.width - 1u + 2u * frame.block_radius - column;
    let start = row * frame.right_stride + (j >> 2u) + 4u * q;
    let shift = (j & 3u) * 8u;
    var words: array<vec4<u32>, VECTORS>;
    var last = right[start];
    for (var v = 0u; v < VECTORS; v++) {
        let at = start + 4u * v;
        let next = vec4(right[at + 1u], right[at + 2u], right[at + 3u], right[at + 4u]);
        words[v] = (vec4(last, next.xyz) >> vec4(shift)) | ((next << vec4(1u)) << vec4(31u - shift));
        last = next.w;
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
    let column = id.x / (QUADS / VECTORS);
    let first = id.x % (QUADS / VECTORS) * VECTORS;
    let count = frame.width + 2u * frame.block_radius;
    let begin = id.y * SEGMENT;
    if column >= count || begin >= pass_.rows {
        return;
    }
    let r = i32(frame.block_radius);
    let y = i32(pass_.first_row + begin);
    var sums: Sums;
    for (var j = -r; j <= r; j++) {
        let row = clamped_row(y - 1 + j);
        let value = left_at(column, row);
        let words = window(column, first, row);
        for (var v = 0u; v < VECTORS; v++) {
            add(&sums, v, differences(value, words[v].x), differences(value, words[v].y),
                differences(value, words[v].z), differences(value, words[v].w));
        }
    }
    let to = min(begin + SEGMENT, pass_.rows);
    for (var line = begin; line < to; line++) {
        let here = i32(pass_.first_row + line);
        let enters = clamped_row(here + r);
        let leaves = clamped_row(here - 1 - r);
        let a = left_at(column, enters);
        let b = left_at(column, leaves);
        let words_a = window(column, first, enters);
        let words_b = window(column, first, leaves);
        let at = ((line * count + column) * QUADS + first) * 2u;
        for (var v = 0u; v < VECTORS; v++) {
            add(&sums, v,
                differences(a, words_a[v].x) - differences(b, words_b[v].x),
                differences(a, words_a[v].y) - differences(b, words_b[v].y),
                differences(a, words_a[v].z) - differences(b, words_b[v].z),
                differences(a, words_a[v].w) - differences(b, words_b[v].w));
            columns[at + 2u * v] = sums[v][0];
            columns[at + 2u * v + 1u] = sums[v][1];
        }
    }
}

// Adds sixteen changes to the sums of vector v.
fn add(sums: ptr<function, Sums>, v: u32, a: vec4<i32>, b: vec4<i32>, c: vec4<i32>, d: vec4<i32>) {
    (*sums)[v][0] += vec4(pair(a.x, a.z), pair(a.y, a.w), pair(b.x, b.z), pair(b.y, b.w));
    (*sums)[v][1] += vec4(pair(c.x, c.z), pair(c.y, c.w), pair(d.x, d.z), pair(d.y, d.w));
}
