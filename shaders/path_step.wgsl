// Appended to the kernels that walk a path: the recurrence of semi-global matching on the packed state L', four
// disparities a word. Disparities beyond the range hold 255, which is never the smallest and never a neighbour's way.
const NONE: u32 = 0xffffu;

// min L'
fn path_minimum(state: ptr<function, array<u32, WORDS>>) -> u32 {
    var least = vec4(NONE);
    for (var q = 0u; q < QUADS; q++) {
        for (var i = 0u; i < 4u; i++) {
            least = min(least, unpack((*state)[4u * q + i]));
        }
    }
    return lowest(least);
}

// T of four disparities: `here` their L', `below` and `above` the L' of the disparities next to them.
fn smoothness(here: vec4<u32>, below: u32, above: u32, least: u32) -> u32 {
    let neighbours = min(vec4(below, here.xyz), vec4(here.yzw, above)) + vec4(frame.p1);
    return pack(min(min(here, neighbours), vec4(least + frame.p2))) - least * 0x01010101u;
}

// Marks the disparities beyond the range.
fn path_close(state: ptr<function, array<u32, WORDS>>) {
    for (var i = 0u; i < 4u; i++) {
        (*state)[WORDS - 4u + i] |= BEYOND[i];
    }
}
