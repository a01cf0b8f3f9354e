// Appended to the kernels that walk a path: P1, and P2 of the step into a pixel, from the bytes that the stage `penalties` left, one
// after the other along a line, so that a load serves sixteen steps. A place is that of a pixel in its line; a path that
// goes the other way finds its step at the pixel before.
@group(0) @binding(PENALTIES) var<storage, read> penalties: array<vec4<u32>>;

fn penalties_from(place: i32, line: u32) -> vec4<u32> {
    return penalties[dispatch.own.penalties_from + u32(place >> 4u) * dispatch.own.penalties_step + line * dispatch.own.penalties_line];
}

fn is_unknown(place: i32, forward: bool) -> bool {
    return (place & 15) == select(15, 0, forward);
}

fn penalty(known: vec4<u32>, place: i32) -> vec2<u32> {
    let k = u32(place) & 15u;
    return vec2(frame.p1, extractBits(known[k / 4u], 8u * (k % 4u), 8u));
}
