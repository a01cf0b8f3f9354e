// winner_beliefs: as winner, of the beliefs: the cost of a pixel and the messages that it receives.
// cost (u8, [y][x][d]), messages (u8, as messages leaves them) -> left_map, right_map (i16)
// MEMBERS invocations: one row of the band, from right to left.
// With: received, winner_row, refinement, totals_wide, costs, common
// Chosen: shared_path*, volume*, cost_*
// Reference: src/reference/winner/winner.rs, src/reference/beliefs/messages.rs

// As in winner.wgsl: all addresses descend.
const BACKWARDS: bool = true;

@group(0) @binding(3) var<storage, read> messages: array<Stored>;
@group(0) @binding(4) var<storage, read> above: array<Stored>;
@group(0) @binding(5) var<storage, read> below: array<Stored>;
@group(0) @binding(6) var<storage, read_write> left_map: array<u32>;
@group(0) @binding(7) var<storage, read_write> right_map: array<u32>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let line = join_group(id.x, local);
    let works = line < dispatch.rows;
    // src/gpu/kernels/source.rs takes this out where barriers follow.
    if !works {
        return;
    }
    let strip_row = min(line, dispatch.rows - 1u);
    let writes = member == 0u && (works || !BARRIERS);
    var costs: Costs;
    var diagonal = no_keys();
    var kept = RowWriter(INVALID, 0, 0, INVALID);
    let steps = row_steps();
    for (var i = 0; i < steps; i++) {
        let x = row_start() - i;
        if inside_row(x) {
            believe(&costs, u32(x), dispatch.volume_row + strip_row);
        }
        choose(&costs, &diagonal, &kept, dispatch.map_row + strip_row, x, writes);
    }
}

fn believe(costs: ptr<function, Costs>, x: u32, row: u32) {
    for (var s = 0u; s < SLICES; s++) {
        if in_volume(s * WIDTH) {
            let cost = costs_at(slice_at(row * frame.volume_stride + x, s));
            let up = from_above(x, row, s);
            let down = from_below(x, row, s);
            let left = from_left(x, row, s);
            let right = from_right(x, row, s);
            for (var w = 0u; w < WIDTH; w++) {
                for (var i = 0u; i < 4u; i++) {
                    (*costs)[s * WIDTH + w][i] = unpack(cost[w][i]) + unpack(up[w][i]) + unpack(down[w][i])
                        + unpack(left[w][i]) + unpack(right[w][i]);
                }
            }
        }
    }
}
