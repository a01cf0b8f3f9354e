// fill_rows_medians: for each invalid pixel the median of the three nearest valid values of its row on the left, and on the right,
//   or of as many as there are; of two the lower one. In the strip before the row's first value, and behind its last, the median
//   is led on by the slope there. What stands at valid pixels nobody reads. Clears seen.
// map (i16, in a texture) -> nearest (i16, eight on the left and eight on the right in turns), seen (a bit a pixel)
// One invocation: a row in one direction.
// With: map_octet, common
// Reference: src/reference/filters/fill.rs

@group(0) @binding(3) var<storage, read_write> nearest: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> seen: array<u32>;

// The last three valid values, the last one in x; invalid where there are none yet.
fn after(before: vec3<i32>, value: i32) -> vec3<i32> {
    return select(vec3(value, before.xy), before, value == INVALID);
}

// Invalid is less than all values: with two of them the one in the middle is the lower, with one it is invalid.
fn median(v: vec3<i32>) -> i32 {
    let middle = max(min(v.x, v.y), min(max(v.x, v.y), v.z));
    return select(middle, v.x, middle == INVALID);
}

// Which of eight columns lie among 16 from column `first` on.
fn among(column: i32, first: i32) -> u32 {
    let skipped = clamp(first - column, 0, 8);
    let beyond = clamp(column - first - 8, 0, 8);
    return (255u << u32(skipped)) & (255u >> u32(beyond));
}

// The median change of the values over 8 columns, in the 16 columns from column `end` on to the right, or to the left, of this
// row and the two above and below it; 0 if there is none.
fn slope(row: u32, end: i32, leftwards: bool) -> i32 {
    // Of two pixels 8 columns apart the left one lies in this column or one of the 15 to its right, and the right one in the image.
    let first = select(end, end - 23, leftwards);
    let last = min(first + 15, i32(frame.width) - 9);
    let way = vec4(select(1, -1, leftwards));
    // What the median may be: in each round half as many numbers, the first of which is `found`.
    var found = -128;
    var pairs = 0u;
    for (var part = 128; part > 0; part >>= 1u) {
        var lower = 0u;
        pairs = 0u;
        for (var y = max(row, 2u) - 2u; y <= min(row + 2u, frame.height - 1u); y++) {
            for (var i = max(first, 0) >> 3u; i <= last >> 3u; i++) {
                let a = octet(y, u32(i));
                let b = octet(y, u32(i) + 1u);
                let both = among(8 * i, first) & mask(
                    min(a.even, b.even) != vec4(INVALID), min(a.odd, b.odd) != vec4(INVALID));
                let least = vec4(found + part);
                pairs += countOneBits(both);
                lower += countOneBits(both & mask(way * (b.even - a.even) < least, way * (b.odd - a.odd) < least));
            }
        }
        found = select(found + part, found, 2u * lower >= pairs);
    }
    return select(found, 0, pairs == 0u);
}

// The value so many columns away from the pixel that a strip begins at. The median lies one further in.
fn led(middle: i32, change: i32, away: vec4<i32>) -> vec4<i32> {
    let least = 16 * frame.min_disparity;
    let by = (change * (away + vec4(1))) >> vec4(3u);
    return clamp(
        middle - clamp(by, vec4(-64), vec4(64)), vec4(least), vec4(least + 16 * (i32(DISPARITIES) - 1)));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.rows {
        return;
    }
    let stride = frame.map_stride / 4u;
    let row = dispatch.first_row + id.x;
    let leftwards = id.y == 1u;
    let turn = vec4(leftwards);
    var last = vec3(INVALID);
    var end = 0; // the column of the last valid value
    for (var n = 0u; n < stride; n++) {
        if id.y == 0u {
            seen[row * stride + n] = 0u;
        }
        let i = select(n, stride - 1u - n, leftwards);
        let p = octet(row, i);
        let valid = mask(p.even != vec4(INVALID), p.odd != vec4(INVALID));
        end = select(end, i32(8u * i + select(firstLeadingBit(valid), firstTrailingBit(valid), leftwards)), valid != 0u);
        // Leftwards the last column is the first.
        let first = select(p.even, p.odd.wzyx, turn);
        let second = select(p.odd, p.even.wzyx, turn);
        var a = vec4(0);
        var b = vec4(0);
        last = after(last, first.x);
        a.x = median(last);
        last = after(last, second.x);
        b.x = median(last);
        last = after(last, first.y);
        a.y = median(last);
        last = after(last, second.y);
        b.y = median(last);
        last = after(last, first.z);
        a.z = median(last);
        last = after(last, second.z);
        b.z = median(last);
        last = after(last, first.w);
        a.w = median(last);
        last = after(last, second.w);
        b.w = median(last);
        nearest[2u * (id.x * (stride + 1u) + i) + id.y] = pack_octet(select(a, b.wzyx, turn), select(b, a.wzyx, turn));
    }
    // Behind it is the strip.
    let border = select(i32(frame.width) - 1, 0, leftwards);
    if last.x == INVALID || end == border {
        return;
    }
    let way = select(1, -1, leftwards);
    let middle = median(last);
    let change = slope(row, end, !leftwards);
    for (var i = u32(min(end, border)) / 8u; i <= u32(max(end, border)) / 8u; i++) {
        let at = 2u * (id.x * (stride + 1u) + i) + id.y;
        let there = nearest[at];
        let even = way * (8 * i32(i) - end + vec4(0, 2, 4, 6));
        let odd = way * (8 * i32(i) - end + vec4(1, 3, 5, 7));
        nearest[at] = pack_octet(
            select(even_values(there), led(middle, change, even), even > vec4(0)),
            select(odd_values(there), led(middle, change, odd), odd > vec4(0)));
    }
}
