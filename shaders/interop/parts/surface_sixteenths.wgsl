// Appended to `surface_draw`: the disparity in 1/16 px.
alias Shown = vec4<i32>;

@group(0) @binding(2) var<storage, read> map: array<u32>;

fn shown_at(at: vec2<u32>) -> Shown {
    return vec4(stereo_disparity(map[stereo_disparity_word(at.x, at.y, 4u * frame.map_stride)], at.x), 0, 0, 1);
}
