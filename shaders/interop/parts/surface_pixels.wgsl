// Appended to `surface_draw` and `surface_store`: the disparity in pixels, which a float holds exactly.
alias Shown = vec4<f32>;

@group(0) @binding(2) var<storage, read> map: array<u32>;

fn shown_at(at: vec2<u32>) -> Shown {
    return vec4(f32(map_value(map[at.y * frame.map_stride + at.x / 2u], at.x)) / 16.0, 0.0, 0.0, 1.0);
}
