// Appended to the kernels that walk a path: the recurrence of semi-global matching on the packed state L', sixteen
// disparities a vector. Disparities beyond the range hold 255, which is never the smallest and never a neighbour's way.
const NONE: u32 = 0xffffu;

alias State = array<vec4<u32>, QUADS>;

// min L'
fn path_minimum(state: ptr<function, State>) -> u32 {
    var least = vec4(NONE);
    for (var q = 0u; q < QUADS; q++) {
        let words = (*state)[q];
        least = min(least, min(min(unpack(words.x), unpack(words.y)), min(unpack(words.z), unpack(words.w))));
    }
    return lowest(least);
}

// T of four disparities: `here` their L', `below` and `above` the L' of the disparities next to them.
fn smoothness(here: vec4<u32>, below: u32, above: u32, least: u32) -> u32 {
    let neighbours = min(vec4(below, here.xyz), vec4(here.yzw, above)) + vec4(frame.p1);
    return pack(min(min(here, neighbours), vec4(least + frame.p2))) - least * 0x01010101u;
}

// One step of a path for the sixteen disparities of vector q: returns their T and leaves L = costs + T in the state.
// `below` is the L' of the disparity before them, and becomes that of the last of them.
fn path_quad(state: ptr<function, State>, q: u32, costs: vec4<u32>, least: u32, below: ptr<function, u32>) -> vec4<u32> {
    let words = (*state)[q];
    let a = unpack(words.x);
    let b = unpack(words.y);
    let c = unpack(words.z);
    let d = unpack(words.w);
    let above = select((*state)[min(q + 1u, QUADS - 1u)].x & 255u, NONE, q + 1u == QUADS);
    let terms = vec4(
        smoothness(a, *below, b.x, least),
        smoothness(b, a.w, c.x, least),
        smoothness(c, b.w, d.x, least),
        smoothness(d, c.w, above, least));
    *below = d.w;
    (*state)[q] = terms + costs;
    if q + 1u == QUADS {
        (*state)[q] |= BEYOND;
    }
    return terms;
}
