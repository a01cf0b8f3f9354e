// median: the fifth of the 3x3 values around a pixel in ascending order, invalid below every valid value.
// map (i16) -> filtered (i16)
// One invocation: one word, two pixels of a row.
// Border: coordinates are clamped into the image; a result that points outside the right image is invalid.
// Reference: src/reference/median.rs

@group(0) @binding(2) var<storage, read> map: array<u32>;
@group(0) @binding(3) var<storage, read_write> filtered: array<u32>;

// Three neighbouring words of a row: the values of columns 2 word - 2 .. 2 word + 3.
fn words(row: u32, word: u32) -> vec3<u32> {
    let start = row * frame.map_stride;
    return vec3(map[start + max(word, 1u) - 1u], map[start + word], map[start + min(word + 1u, frame.map_stride - 1u)]);
}

// The three values of a column, ascending; column 0 is the left one of the middle word.
fn column(rows: array<vec3<u32>, 3>, word: u32, offset: i32) -> vec3<i32> {
    let x = clamp(i32(2u * word) + offset, 0, i32(frame.width) - 1) - i32(2u * word);
    let v = vec3(pick(rows[0], x), pick(rows[1], x), pick(rows[2], x));
    let low = min(v.x, v.y);
    let high = max(v.x, v.y);
    return vec3(min(low, v.z), max(low, min(high, v.z)), max(high, v.z));
}

fn pick(words: vec3<u32>, x: i32) -> i32 {
    return map_value(select(select(words.z, words.y, x < 2), words.x, x < 0), u32(x) & 1u);
}

fn middle(a: i32, b: i32, c: i32) -> i32 {
    return max(min(a, b), min(max(a, b), c));
}

// The median of nine is the middle of: the largest minimum, the middle middle and the smallest maximum of the columns.
fn median(a: vec3<i32>, b: vec3<i32>, c: vec3<i32>, x: i32) -> i32 {
    let value = middle(max(max(a.x, b.x), c.x), middle(a.y, b.y, c.y), min(min(a.z, b.z), c.z));
    return select(INVALID, value, points_inside(x, value));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.map_stride || id.y >= frame.height {
        return;
    }
    let rows = array(
        words(max(id.y, 1u) - 1u, id.x), words(id.y, id.x), words(min(id.y + 1u, frame.height - 1u), id.x));
    let a = column(rows, id.x, -1);
    let b = column(rows, id.x, 0);
    let c = column(rows, id.x, 1);
    let d = column(rows, id.x, 2);
    let x = i32(2u * id.x);
    filtered[id.y * frame.map_stride + id.x] = map_word(median(a, b, c, x), median(b, c, d, x + 1));
}
