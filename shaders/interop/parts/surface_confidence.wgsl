// Appended to `surface_draw`: the confidence, where 255 becomes 1.
alias Shown = vec4<f32>;

@group(0) @binding(2) var<storage, read> confidence: array<u32>;

fn shown_at(at: vec2<u32>) -> Shown {
    let word = confidence[stereo_confidence_word(at.x, at.y, 2u * frame.map_stride)];
    return vec4(f32(stereo_confidence(word, at.x)) / 255.0, 0.0, 0.0, 1.0);
}
