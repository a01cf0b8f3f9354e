// sad_cost: (sum of 2 r + 1 neighbouring columns * cost_scale + 2^23) >> 24, from 0 to 89.
// columns (u16, [y][x + r][d]) -> cost (u8, [y][x][d], four disparities a word)
// MEMBERS invocations: one row of the band, from left to right; a column enters the sum as another leaves it.
// Border: the columns reach beyond it. Disparities beyond the range are computed like the others and never used.
// Reference: src/reference/sad_cost.rs

const BACKWARDS: bool = false;

@group(0) @binding(2) var<storage, read> columns: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> cost: array<vec4<u32>>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let row = join_group(id.x, local);
    if row >= pass_.rows {
        return;
    }
    let reach = 2u * frame.block_radius;
    let first = row * (frame.width + reach) * 2u * QUADS;
    var sums: Costs;
    for (var c = 0u; c < reach; c++) {
        enter(&sums, first + c * 2u * QUADS);
    }
    for (var x = 0u; x < frame.width; x++) {
        let leaves = first + x * 2u * QUADS;
        enter(&sums, leaves + reach * 2u * QUADS);
        let at = ((pass_.volume_row + row) * frame.width + x) * QUADS + member * OWN_QUADS;
        for (var q = 0u; q < OWN_QUADS; q++) {
            let own = &sums[q];
            if in_volume(q) {
                cost[at + q] = vec4(quantised((*own)[0]), quantised((*own)[1]), quantised((*own)[2]), quantised((*own)[3]));
            }
        }
        leave(&sums, leaves);
    }
}
