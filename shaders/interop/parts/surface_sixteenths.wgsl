// Appended to `surface_draw`: the disparity in 1/16 px.
alias Shown = vec4<i32>;

@group(0) @binding(2) var<storage, read> map: array<u32>;

fn shown_at(at: vec2<u32>) -> Shown {
    return vec4(map_value(map[at.y * frame.map_stride + at.x / 2u], at.x), 0, 0, 1);
}
