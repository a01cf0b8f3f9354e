// sgm_aggregate: L(d) = C(d) + T(d), T(d) = min(L'(d), L'(d - 1) + P1, L'(d + 1) + P1, min L' + P2) - min L',
//   L' of the pixel before on the path; T = 0 where the path starts.
// cost (u8, [y][x][d]) -> paths (u8, [y][x][d]): T of this direction, or that plus what is there (accumulate);
//   T <= P2 <= 127, so the sum of two directions fits a byte.
// MEMBERS invocations: one path through the band; the state stays packed in registers. A diagonal path that leaves the image
//   at a side enters again on the other one as a new path, so that all invocations take as many steps.
// carry_in, carry_out (u8, [x][d]): L of the last row of the band before and of this band, for paths that cross bands.
// With: path_step, common
// Chosen: shared_path*, volume*, cost_*, penalty_*
// Reference: src/reference/paths/sgm_aggregate.rs

const BACKWARDS: bool = false;

@group(0) @binding(3) var<storage, read_write> paths: array<Stored>;
@group(0) @binding(4) var<storage, read> carry_in: array<Stored>;
@group(0) @binding(5) var<storage, read_write> carry_out: array<Stored>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let horizontal = dispatch.dy == 0;
    let width = i32(frame.width);
    let group = join_group(id.x, local);
    let works = group < dispatch.lines;
    // src/gpu/kernels/source.rs takes this out where barriers follow.
    if !works {
        return;
    }
    let line = i32(dispatch.first_line + min(group, dispatch.lines - 1u));
    let enters = i32((u32(line) + dispatch.shift) % frame.width);
    var x = select(enters, select(width - 1, 0, dispatch.dx > 0), horizontal);
    let y = select(dispatch.entry, line, horizontal);
    var state: State;
    let before = x - dispatch.dx;
    let first_carry = dispatch.own.carry_from * frame.volume_stride;
    if dispatch.carried == 1u && before >= 0 && before < width {
        for (var s = 0u; s < SLICES; s++) {
            if in_volume(s * WIDTH) {
                state[s] = slice_of(carry_in[slice_at(first_carry + u32(before), s)]);
            }
            for (var w = 0u; w < WIDTH; w++) {
                state[s][w] |= beyond(s * WIDTH + w);
            }
        }
    }
    let stride = i32(frame.volume_stride);
    var at = y * stride + x;
    let turn = select(-width, width, dispatch.dx > 0);
    let steps = select(i32(dispatch.rows), width, horizontal);
    let forward = dispatch.dy > 0 || (horizontal && dispatch.dx > 0);
    var place = dispatch.own.place;
    var known = penalties_from(place, u32(line));
    for (var i = 0; i < steps; i++) {
        if is_unknown(place, forward) {
            known = penalties_from(place, u32(line));
        }
        path_step(&state, u32(at), penalty(known, place), works || !BARRIERS);
        place += select(-1, 1, forward);
        at += dispatch.dy * stride + dispatch.dx;
        x += dispatch.dx;
        // A mask in place of a branch, which would copy the state.
        let leaves = !horizontal && (x < 0 || x >= width);
        let keep = vec4(select(0xffffffffu, 0u, leaves));
        for (var s = 0u; s < SLICES; s++) {
            for (var w = 0u; w < WIDTH; w++) {
                state[s][w] &= keep;
            }
        }
        let back = select(0, turn, leaves);
        x -= back;
        at -= back;
    }
    if !horizontal && works {
        // The state belongs to the pixel before x. After a wrap the next row's path starts anew and needs none.
        let last = x - dispatch.dx;
        if last >= 0 && last < width {
            for (var s = 0u; s < SLICES; s++) {
                if in_volume(s * WIDTH) {
                    carry_out[slice_at(dispatch.own.carry_to * frame.volume_stride + u32(last), s)] = stored_of(state[s]);
                }
            }
        }
    }
}

fn path_step(state: ptr<function, State>, pixel: u32, steps: vec2<u32>, writes: bool) {
    var around = surroundings(state);
    for (var s = 0u; s < SLICES; s++) {
        var costs = Slice();
        var sums = Slice();
        if in_volume(s * WIDTH) {
            costs = costs_at(slice_at(pixel + dispatch.volume_row * frame.volume_stride, s));
            if dispatch.own.accumulate == 1u {
                sums = slice_of(paths[slice_at(pixel + dispatch.slot, s)]);
            }
        }
        let terms = path_slice(state, s, costs, steps, &around);
        for (var w = 0u; w < WIDTH; w++) {
            sums[w] += terms[w];
        }
        if in_volume(s * WIDTH) && writes {
            paths[slice_at(pixel + dispatch.slot, s)] = stored_terms(sums);
        }
    }
}
