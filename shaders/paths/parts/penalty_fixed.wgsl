// Appended to the kernels that walk a path: P1 and P2 of the step into a pixel, the same for all.
fn penalties_from(place: i32, line: u32) -> vec4<u32> {
    return vec4(0u);
}

// Whether the step into the pixel at a place is the first one that is not yet known.
fn is_unknown(place: i32, forward: bool) -> bool {
    return false;
}

fn penalty(known: vec4<u32>, place: i32) -> vec2<u32> {
    return vec2(frame.p1, frame.p2);
}
