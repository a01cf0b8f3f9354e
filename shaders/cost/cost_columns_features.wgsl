// cost_columns_features: cost_columns of pixels that are compared by their features.
// left, right (features, bytes with signs, [block of four][row][column]) -> columns (u16 or u32, [y][x + r][d], width + 2 r columns)
// One invocation: sixteen disparities of one column, COLUMN_ROWS rows downwards; a row enters the sum as another leaves it.
//   Neighbouring invocations take the disparities of one column, then those of the next column.
// Border: rows and columns are clamped into the images.
// With: angles, differences, common
// Chosen: products_*, beside_*, pixel_census_sobel, pixel_bits, sums*
// Reference: src/reference/cost/cost_columns.rs

@group(0) @binding(2) var<storage, read> left: array<u32>;
@group(0) @binding(3) var<storage, read> right: array<u32>;
@group(0) @binding(4) var<storage, read_write> columns: array<vec4<u32>>;

// Of the features.
fn clamped_row(y: i32) -> u32 {
    return u32(clamp(y, 0, i32(frame.height) - 1)) - dispatch.planes_row;
}

fn clamped_column(x: i32) -> u32 {
    return u32(clamp(x, 0, i32(frame.width) - 1));
}

// The costs between a left pixel of a row and sixteen right ones.
fn row_sums(column: u32, q: u32, row: u32) -> Sums {
    let x = i32(column) - i32(frame.block_radius);
    let stride = (frame.width + 3u) / 4u * 4u;
    var sums: array<Sum, 16>;
    for (var block = 0u; block < FEATURES / 4u; block++) {
        let start = (block * dispatch.planes_rows + row) * stride;
        let pixel = four_of(left[start + clamped_column(x)]);
        for (var d = 0u; d < 16u; d++) {
            let seen = clamped_column(x - frame.min_disparity - i32(16u * q + d));
            sums[d] = plus_products(sums[d], pixel, four_of(right[start + seen]));
        }
    }
    let costs = with_others(angles(sums), column, q, row);
    return sums_of(array(low_pairs(costs), high_pairs(costs)));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let column = id.x / QUADS;
    let q = id.x % QUADS;
    let count = frame.width + 2u * frame.block_radius;
    let begin = id.y * COLUMN_ROWS;
    if column >= count || begin >= dispatch.rows {
        return;
    }
    let r = i32(frame.block_radius);
    let y = i32(dispatch.first_row + begin);
    var sums: Sums;
    for (var j = -r; j <= r; j++) {
        var enters = row_sums(column, q, clamped_row(y - 1 + j));
        for (var part = 0u; part < PARTS_OF_SUMS; part++) {
            sums[part] += enters[part];
        }
    }
    let to = min(begin + COLUMN_ROWS, dispatch.rows);
    for (var line = begin; line < to; line++) {
        let here = i32(dispatch.first_row + line);
        var enters = row_sums(column, q, clamped_row(here + r));
        var leaves = row_sums(column, q, clamped_row(here - 1 - r));
        let at = ((line * count + column) * QUADS + q) * PARTS_OF_SUMS;
        for (var part = 0u; part < PARTS_OF_SUMS; part++) {
            // Of two sums in a word: carries between the halves cancel.
            sums[part] += enters[part] - leaves[part];
            columns[at + part] = sums[part];
        }
    }
}
