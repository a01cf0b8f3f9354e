// Appended to the kernels that walk a path: the recurrence of semi-global matching on the packed state L', sixteen
// disparities a vector. MEMBERS invocations share a path; each owns OWN_QUADS vectors of its disparities. Disparities
// beyond the range hold 255, which is never the smallest L' and never chosen by a neighbour.

struct Own {
    accumulate: u32,        // 1: add to the result of the opposite direction
    carry_from: u32,        // row of carry_in and of carry_out
    carry_to: u32,
    penalties_from: u32,    // vectors of penalties: before the first line
    penalties_line: u32,    // from line to line
    penalties_step: u32,    // from one to the next of a line
    place: i32,             // in its line, of the step into the first pixel of a path
}

alias State = array<Slice, SLICES>;

// What the members of a path exchange before a step: min L', and the L' next to a member's own.
fn surroundings(state: ptr<function, State>) -> Surroundings {
    var least = vec4(NONE);
    for (var s = 0u; s < SLICES; s++) {
        for (var w = 0u; w < WIDTH; w++) {
            let words = (*state)[s][w];
            least = min(least, min(min(unpack(words.x), unpack(words.y)), min(unpack(words.z), unpack(words.w))));
        }
    }
    return exchange(lowest(least), (*state)[0][0].x & 255u, (*state)[SLICES - 1u][WIDTH - 1u].w >> 24u);
}

// T of four disparities: `here` their L', `below` and `above` the L' of the disparities next to them; P1 and P2.
fn smoothness(here: vec4<u32>, below: u32, above: u32, least: u32, steps: vec2<u32>) -> u32 {
    let neighbours = min(vec4(below, here.xyz), vec4(here.yzw, above)) + vec4(steps.x);
    return pack(min(min(here, neighbours), vec4(least + steps.y))) - least * 0x01010101u;
}

// One step of a path for slice s, with its P1 and P2: returns its T and leaves L = costs + T in the state. `around.below` is the
// L' of the disparity before the slice, and becomes that of its last one.
fn path_slice(state: ptr<function, State>, s: u32, costs: Slice, steps: vec2<u32>,
              around: ptr<function, Surroundings>) -> Slice {
    var terms: Slice;
    for (var w = 0u; w < WIDTH; w++) {
        let words = (*state)[s][w];
        let a = unpack(words.x);
        let b = unpack(words.y);
        let c = unpack(words.z);
        let d = unpack(words.w);
        let after = (*state)[min(s + 1u, SLICES - 1u)][0].x;
        let next = select(after, (*state)[s][min(w + 1u, WIDTH - 1u)].x, w + 1u < WIDTH);
        let above = select(next & 255u, (*around).above, s + 1u == SLICES && w + 1u == WIDTH);
        let least = (*around).least;
        terms[w] = vec4(
            smoothness(a, (*around).below, b.x, least, steps),
            smoothness(b, a.w, c.x, least, steps),
            smoothness(c, b.w, d.x, least, steps),
            smoothness(d, c.w, above, least, steps));
        (*around).below = d.w;
        (*state)[s][w] = (terms[w] + costs[w]) | beyond(s * WIDTH + w);
    }
    return terms;
}
