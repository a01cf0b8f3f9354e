// Appended to `surface_draw` and `surface_store`: the depth in micrometres, 0 where there is none.
alias Shown = vec4<u32>;

@group(0) @binding(2) var<storage, read> depth: array<u32>;

fn shown_at(at: vec2<u32>) -> Shown {
    return vec4(depth[stereo_depth_word(at.x, at.y, 8u * frame.map_stride)], 0u, 0u, 1u);
}
