// cost_columns: sums over |j| <= r of the pixel costs between left(x, y + j) and right(x - min_disparity - d, y + j).
// left, right (planes of descriptors) -> columns (u16 or u32, [y][x + r][d], width + 2 r columns, only the band's rows)
// One invocation: VECTORS x 16 disparities of one column, SEGMENT rows downwards; a row enters the sum as another leaves
//   it. Neighbouring invocations take the disparities of one column, then those of the next column.
// Border: rows are clamped into the image; the planes continue the columns.
// With: differences, common
// Chosen: pixel_*, sums*
// Reference: src/reference/cost/cost_columns.rs

@group(0) @binding(2) var<storage, read> left: array<u32>;
@group(0) @binding(3) var<storage, read> right: array<u32>;
@group(0) @binding(4) var<storage, read_write> columns: array<vec4<u32>>;

alias AllSums = array<Sums, VECTORS>;

// Of the planes.
fn clamped_row(y: i32) -> u32 {
    return u32(clamp(y, 0, i32(frame.height) - 1)) - dispatch.planes_row;
}

fn left_at(column: u32, row: u32) -> Pixel {
    var pixel: Pixel;
    for (var p = 0u; p < PLANES; p++) {
        let word = left[(p * dispatch.planes_rows + row) * frame.left_stride + (column >> 2u)];
        pixel[p] = extractBits(word, (column & 3u) * 8u, 8u) * 0x01010101u;
    }
    return pixel;
}

// The right pixels that the disparities are compared with, from vector q of them on.
fn windows(column: u32, q: u32, row: u32) -> array<Window, VECTORS> {
    let j = frame.width - 1u + 2u * frame.block_radius - column;
    let shift = (j & 3u) * 8u;
    var found: array<Window, VECTORS>;
    for (var p = 0u; p < PLANES; p++) {
        let start = (p * dispatch.planes_rows + row) * frame.right_stride + (j >> 2u) + 4u * q;
        var last = right[start];
        for (var v = 0u; v < VECTORS; v++) {
            let at = start + 4u * v;
            let next = vec4(right[at + 1u], right[at + 2u], right[at + 3u], right[at + 4u]);
            found[v][p] = (vec4(last, next.xyz) >> vec4(shift)) | ((next << vec4(1u)) << vec4(31u - shift));
            last = next.w;
        }
    }
    return found;
}

// The costs between a left pixel of a row and the right ones.
fn row_sums(column: u32, q: u32, row: u32) -> AllSums {
    let pixel = left_at(column, row);
    var found = windows(column, q, row);
    var sums: AllSums;
    for (var v = 0u; v < VECTORS; v++) {
        sums[v] = sums_of(pixel_pairs(pixel, found[v]));
    }
    return sums;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let column = id.x / (QUADS / VECTORS);
    let first = id.x % (QUADS / VECTORS) * VECTORS;
    let count = frame.width + 2u * frame.block_radius;
    let begin = id.y * SEGMENT;
    if column >= count || begin >= dispatch.rows {
        return;
    }
    let r = i32(frame.block_radius);
    let y = i32(dispatch.first_row + begin);
    var sums: AllSums;
    for (var j = -r; j <= r; j++) {
        var enters = row_sums(column, first, clamped_row(y - 1 + j));
        for (var v = 0u; v < VECTORS; v++) {
            for (var part = 0u; part < PARTS_OF_SUMS; part++) {
                sums[v][part] += enters[v][part];
            }
        }
    }
    let to = min(begin + SEGMENT, dispatch.rows);
    for (var line = begin; line < to; line++) {
        let here = i32(dispatch.first_row + line);
        var enters = row_sums(column, first, clamped_row(here + r));
        var leaves = row_sums(column, first, clamped_row(here - 1 - r));
        let at = ((line * count + column) * QUADS + first) * PARTS_OF_SUMS;
        for (var v = 0u; v < VECTORS; v++) {
            for (var part = 0u; part < PARTS_OF_SUMS; part++) {
                // Of two sums in a word: carries between the halves cancel.
                sums[v][part] += enters[v][part] - leaves[v][part];
                columns[at + PARTS_OF_SUMS * v + part] = sums[v][part];
            }
        }
    }
}
