// Appended to `surface_draw`: the confidence, where 255 becomes 1.
alias Shown = vec4<f32>;

@group(0) @binding(2) var<storage, read> confidence: array<u32>;

fn shown_at(at: vec2<u32>) -> Shown {
    let word = confidence[at.y * (frame.map_stride / 2u) + at.x / 4u];
    return vec4(f32(extractBits(word, (at.x & 3u) * 8u, 8u)) / 255.0, 0.0, 0.0, 1.0);
}
