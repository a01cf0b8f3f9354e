// Appended to the kernels that walk a path: as penalty_lines, where the stage `penalties` left two bytes a step, P2 and P1, so that
// a load serves eight steps.
@group(0) @binding(PENALTIES) var<storage, read> penalties: array<vec4<u32>>;

fn penalties_from(place: i32, line: u32) -> vec4<u32> {
    return penalties[dispatch.own.penalties_from + u32(place >> 3u) * dispatch.own.penalties_step + line * dispatch.own.penalties_line];
}

fn is_unknown(place: i32, forward: bool) -> bool {
    return (place & 7) == select(7, 0, forward);
}

fn penalty(known: vec4<u32>, place: i32) -> vec2<u32> {
    let k = u32(place) & 7u;
    let both = extractBits(known[k / 2u], 16u * (k % 2u), 16u);
    return vec2(both >> 8u, both & 255u);
}
