// winner: the disparity of the smallest S(d) = PATHS C(d) + sum of T(d) over all directions; the right view likewise.
// cost, the T of all directions but the leftward one (pairs in a byte; u8, [y][x][d]) -> left_map, right_map (i16)
//   The leftward direction of sgm_aggregate is walked here, so its T is never stored. PAIRED volumes hold two
//   directions each, the i-th in buffer i % 3; `forward` holds the rightward one.
// MEMBERS invocations: one row of the band, from right to left.
// With: path_step, winner_row, refinement, totals_pairs, pairs, common
// Chosen: shared_path*, volume*, cost_*, penalty_*
// Reference: src/reference/winner/winner.rs, src/reference/paths/sgm_aggregate.rs

// A row is walked backwards, and so is a pixel by its members: then all addresses descend, which CPUs prefetch.
const BACKWARDS: bool = true;

@group(0) @binding(3) var<storage, read> forward: array<Stored>;
@group(0) @binding(4) var<storage, read> paired0: array<Stored>;
@group(0) @binding(5) var<storage, read> paired1: array<Stored>;
@group(0) @binding(6) var<storage, read> paired2: array<Stored>;
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
fn walk(state: ptr<function, State>, totals: ptr<function, Totals>, strip_pixel: u32, p2: u32) {
    let pixel = dispatch.volume_row * frame.volume_stride + strip_pixel;
    var around = surroundings(state);
    for (var s = 0u; s < SLICES; s++) {
        var c = Slice();
        var t = array<Slice, PAIRED + 1u>();
        if in_volume(s * WIDTH) {
            c = costs_at(slice_at(pixel, s));
            t[0] = slice_of(forward[slice_at(strip_pixel, s)]);
            t[1] = slice_of(paired0[slice_at(pixel, s)]);
            for (var i = 1u; i < PAIRED; i++) {
                let at = slice_at(pixel + i / 3u * dispatch.slot, s);
                switch i % 3u {
                    case 0u: { t[i + 1u] = slice_of(paired0[at]); }
                    case 1u: { t[i + 1u] = slice_of(paired1[at]); }
                    default: { t[i + 1u] = slice_of(paired2[at]); }
                }
            }
        }
        let own = path_slice(state, s, c, p2, &around);
        for (var w = 0u; w < WIDTH; w++) {
            let own_cost = pairs_of(c[w]);
            // Of this direction and the opposite one: both T are at most 127.
            let horizontal = pairs_of(own[w] + t[0][w]);
            var sums = sum_of(Pairs(PATHS * own_cost.even, PATHS * own_cost.odd), horizontal);
            for (var i = 1u; i < PAIRED + 1u; i++) {
                sums = sum_of(sums, pairs_of(t[i][w]));
            }
            (*totals)[s * WIDTH + w] = sums;
        }
    }
}
