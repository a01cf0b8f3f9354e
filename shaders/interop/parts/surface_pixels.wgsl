// Appended to `surface_draw` and `surface_store`: the disparity in pixels, rounded to the DIGITS binary digits that the texture
// holds, so that storing it is exact: 11, or 24, which hold every disparity.
alias Shown = vec4<f32>;

@group(0) @binding(2) var<storage, read> map: array<u32>;

fn shown_at(at: vec2<u32>) -> Shown {
    let value = stereo_disparity(map[stereo_disparity_word(at.x, at.y, 4u * frame.map_stride)], at.x);
    let pixels = f32(stereo_nearest(u32(abs(value)), DIGITS)) / 16.0;
    return vec4(select(pixels, -pixels, value < 0), 0.0, 0.0, 1.0);
}
