// block_match: the disparity of the smallest cost of a block; the right view likewise.
// columns (u16 or u32, [y][x + r][d]), with ncc statistics ([y][left, then right blocks]) -> left_map, right_map (i16)
// MEMBERS invocations: one row of the band, from right to left; a column enters the sum as another leaves it.
// Border: the columns reach beyond it.
// With: column_sums, costs, totals_wide, winner_row, refinement, common
// Chosen: shared_path*, sums*, block_costs_*
// Reference: src/reference/winner/block_match.rs

// As in winner.wgsl: all addresses descend.
const BACKWARDS: bool = true;

@group(0) @binding(2) var<storage, read> columns: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> left_map: array<u32>;
@group(0) @binding(4) var<storage, read_write> right_map: array<u32>;
@group(0) @binding(5) var<storage, read> statistics: array<vec2<u32>>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let line = join_group(id.x, local);
    let works = line < dispatch.rows;
    // src/gpu/kernels/source.rs takes this out where barriers follow.
    if !works {
        return;
    }
    let band_row = min(line, dispatch.rows - 1u);
    let writes = member == 0u && (works || !BARRIERS);
    let reach = 2u * frame.block_radius;
    let first = band_row * (frame.width + reach) * QUADS;
    var sums = Costs();
    var costs: Costs;
    var seen = none_seen(band_row);
    var diagonal = no_keys();
    for (var c = 0u; c < reach; c++) {
        enter(&sums, first + (frame.width + c) * QUADS);
    }
    var kept = RowWriter(INVALID, 0, 0, INVALID);
    let steps = row_steps();
    for (var i = 0; i < steps; i++) {
        let x = row_start() - i;
        if inside_row(x) {
            let at = first + u32(x) * QUADS;
            enter(&sums, at);
            block_costs(&costs, &sums, &seen, band_row, x);
            leave(&sums, at + reach * QUADS);
        }
        choose(&costs, &diagonal, &kept, dispatch.map_row + band_row, x, writes);
    }
}

// A column enters the sums.
fn enter(sums: ptr<function, Costs>, at: u32) {
    for (var q = 0u; q < OWN_QUADS; q++) {
        if in_volume(q) {
            let column = column_at(at + member * OWN_QUADS + q);
            for (var i = 0u; i < 4u; i++) {
                (*sums)[q][i] += column[i];
            }
        }
    }
}

// A column leaves the sums.
fn leave(sums: ptr<function, Costs>, at: u32) {
    for (var q = 0u; q < OWN_QUADS; q++) {
        if in_volume(q) {
            let column = column_at(at + member * OWN_QUADS + q);
            for (var i = 0u; i < 4u; i++) {
                (*sums)[q][i] -= column[i];
            }
        }
    }
}
