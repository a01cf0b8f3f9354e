// second_cost: C(d) + floor((sum of T(d) + n) / (2 n)), the cost of the second pass; T of all n directions of the first one.
// cost, the T of all directions but the leftward one (pairs in a byte; u8, [y][x][d]) -> paired0 (u8, [y][x][d]), in the place of
//   the first pair's T; at most 89 + 64. The leftward direction of sgm_aggregate is walked here, so its T is never stored.
// MEMBERS invocations: one row of the band, from right to left.
// With: path_step, row_step, pairs, common
// Chosen: shared_path*, volume*, cost_*, penalty_*
// Reference: src/reference/paths/second_cost.rs

@group(0) @binding(4) var<storage, read_write> paired0: array<Stored>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let line = join_group(id.x, local);
    let works = line < dispatch.rows;
    // src/gpu/kernels/source.rs takes this out where barriers follow.
    if !works {
        return;
    }
    let strip_row = min(line, dispatch.rows - 1u);
    var state: State;
    var known = penalties_from(i32(frame.width), strip_row);
    for (var i = 1u; i <= frame.width; i++) {
        let x = frame.width - i;
        // What the penalties are outside the image does not matter.
        let place = i32(x) + 1;
        if is_unknown(place, false) {
            known = penalties_from(place, strip_row);
        }
        walk(&state, strip_row * frame.volume_stride + x, penalty(known, place), works || !BARRIERS);
    }
}

// One step of the leftward path, and the cost of the pixel.
fn walk(state: ptr<function, State>, strip_pixel: u32, steps: vec2<u32>, writes: bool) {
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
            let half = vec4(PATHS * 0x10001u);
            let sums = sum_of_terms(Pairs(half, half), own[w], &t, w);
            c[w] += share(sums.even) | (share(sums.odd) << vec4(8u));
        }
        if in_volume(s * WIDTH) && writes {
            paired0[slice_at(pixel, s)] = stored_terms(c);
        }
    }
}

// floor(a / (2 PATHS)) of two numbers of 16 bits a word, at most 128 PATHS each.
fn share(pairs: vec4<u32>) -> vec4<u32> {
    if (PATHS & (PATHS - 1u)) == 0u {
        return (pairs >> vec4(PATH_BITS + 1u)) & vec4(0x7f007fu);
    }
    // The factor is at most 1/65536 too large, for its part.
    let factor = vec4(32768u / PATHS + 1u);
    return (((pairs & vec4(0xffffu)) * factor) >> vec4(16u)) | (((pairs >> vec4(16u)) * factor) & vec4(0xffff0000u));
}
