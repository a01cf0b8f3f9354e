// Appended to `surface_draw` and `surface_store`: the depth in metres, rounded to the DIGITS binary digits that the texture
// holds, so that storing it is exact; of 11 digits at least the smallest number that has them all. 0 where there is none.
alias Shown = vec4<f32>;

@group(0) @binding(2) var<storage, read> depth: array<u32>;

fn shown_at(at: vec2<u32>) -> Shown {
    let micrometres = depth[stereo_depth_word(at.x, at.y, 8u * frame.map_stride)];
    let least = select(0.0, 0.00006103515625, DIGITS == 11u); // 2^-14
    let metres = max(stereo_rounded_metres(micrometres, DIGITS), least);
    return vec4(select(metres, 0.0, micrometres == 0u), 0.0, 0.0, 1.0);
}
