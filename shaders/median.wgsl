// median: the fifth of the 3x3 values around a pixel in ascending order, invalid below every valid value.
// map (i16) -> filtered (i16)
// One invocation: one word, two pixels of a row.
// Border: coordinates are clamped into the image; a result that points outside the right image is invalid.
// Reference: src/reference/median.rs

@group(0) @binding(2) var<storage, read> map: array<u32>;
@group(0) @binding(3) var<storage, read_write> filtered: array<u32>;

fn at(x: i32, row: u32) -> i32 {
    let column = u32(clamp(x, 0, i32(frame.width) - 1));
    return map_value(map[row * frame.map_stride + (column >> 1u)], column);
}

// The three values of a column, ascending.
fn column(x: i32, above: u32, row: u32, below: u32) -> vec3<i32> {
    let v = vec3(at(x, above), at(x, row), at(x, below));
    let low = min(v.x, v.y);
    let high = max(v.x, v.y);
    return vec3(min(low, v.z), max(low, min(high, v.z)), max(high, v.z));
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
    let above = max(id.y, 1u) - 1u;
    let below = min(id.y + 1u, frame.height - 1u);
    let x = i32(2u * id.x);
    let a = column(x - 1, above, id.y, below);
    let b = column(x, above, id.y, below);
    let c = column(x + 1, above, id.y, below);
    let d = column(x + 2, above, id.y, below);
    filtered[id.y * frame.map_stride + id.x] = map_word(median(a, b, c, x), median(b, c, d, x + 1));
}
