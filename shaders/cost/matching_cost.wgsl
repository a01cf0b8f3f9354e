// matching_cost: (sum of 2 r + 1 neighbouring columns * cost_scale + 2^23) >> 24, from 0 to 89.
// columns (u16 or u32, [y][x + r][d]) -> cost (u8, [y][x][d], four disparities a word)
// One invocation: sixteen disparities of SPAN pixels of a row of the band, from left to right; a column enters the sum as
//   another leaves it. Neighbouring invocations take the disparities of one pixel.
// Border: the column sums reach beyond the image. Disparities beyond the range are computed like the others, never used.
// With: column_sums, differences, quantise, common
// Chosen: sums*
// Reference: src/reference/cost/matching_cost.rs

@group(0) @binding(2) var<storage, read> columns: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> cost: array<vec4<u32>>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = id.x / QUADS;
    let q = id.x % QUADS;
    let begin = id.y * SPAN;
    if row >= dispatch.rows || begin >= frame.width {
        return;
    }
    let reach = 2u * frame.block_radius;
    let first = row * (frame.width + reach) * QUADS + q;
    var sums: array<vec4<u32>, 4>;
    for (var c = begin; c < begin + reach; c++) {
        let column = column_at(first + c * QUADS);
        for (var part = 0u; part < 4u; part++) {
            sums[part] += column[part];
        }
    }
    for (var x = begin; x < min(begin + SPAN, frame.width); x++) {
        let enters = column_at(first + (x + reach) * QUADS);
        for (var part = 0u; part < 4u; part++) {
            sums[part] += enters[part];
        }
        cost[((dispatch.volume_row + row) * frame.volume_stride + x) * QUADS + q] =
            vec4(quantised(sums[0]), quantised(sums[1]), quantised(sums[2]), quantised(sums[3]));
        let leaves = column_at(first + x * QUADS);
        for (var part = 0u; part < 4u; part++) {
            sums[part] -= leaves[part];
        }
    }
}
