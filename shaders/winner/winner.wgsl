// winner: the disparity of the smallest S(d) = PATHS C(d) + sum of T(d) over all directions; the right view likewise.
// cost, the T of all directions but the leftward one (pairs in a byte; u8, [y][x][d]) -> left_map, right_map (i16)
//   The leftward direction of sgm_aggregate is walked here, so its T is never stored.
// MEMBERS invocations: one row of the band, from right to left.
// With: path_step, row_step, winner_row, refinement, totals_pairs, pairs, common
// Chosen: shared_path*, volume*, cost_*, penalty_*
// Reference: src/reference/winner/winner.rs, src/reference/paths/sgm_aggregate.rs

@group(0) @binding(4) var<storage, read> paired0: array<Stored>;
@group(0) @binding(7) var<storage, read_write> left_map: array<u32>;
@group(0) @binding(8) var<storage, read_write> right_map: array<u32>;

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
    var state: State;
    var totals: Totals;
    var diagonal = no_keys();
    var kept = RowWriter(INVALID, 0, 0, INVALID);
    let steps = row_steps();
    var known = penalties_from(i32(frame.width), strip_row);
    for (var i = 0; i < steps; i++) {
        let x = row_start() - i;
        // What P2 is outside the image does not matter.
        if is_unknown(x + 1, false) {
            known = penalties_from(clamp(x + 1, 0, i32(frame.width)), strip_row);
        }
        if inside_row(x) {
            walk(&state, &totals, strip_row * frame.volume_stride + u32(x), penalty(known, x + 1));
        }
        choose(&totals, &diagonal, &kept, dispatch.map_row + strip_row, x, writes);
    }
}

// One step of the leftward path, and S of the pixel.
fn walk(state: ptr<function, State>, totals: ptr<function, Totals>, strip_pixel: u32, steps: vec2<u32>) {
    let pixel = dispatch.volume_row * frame.volume_stride + strip_pixel;
    var around = surroundings(state);
    for (var s = 0u; s < SLICES; s++) {
        var c = Slice();
        var t = Terms();
        if in_volume(s * WIDTH) {
            c = costs_at(slice_at(pixel, s));
            t = terms_of(pixel, strip_pixel, s);
        }
        let own = path_slice(state, s, c, steps, &around);
        for (var w = 0u; w < WIDTH; w++) {
            let cost = pairs_of(c[w]);
            (*totals)[s * WIDTH + w] = sum_of_terms(Pairs(PATHS * cost.even, PATHS * cost.odd), own[w], &t, w);
        }
    }
}
