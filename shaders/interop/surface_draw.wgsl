// surface_draw: the value that `shown_at` gives for each pixel, drawn into the caller's texture.
// One triangle covers the target. One fragment: one pixel.
// With: common
// Chosen: surface_*
// Reference: src/color.rs, src/image.rs

@vertex
fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn main(@builtin(position) at: vec4<f32>) -> @location(0) Shown {
    return shown_at(vec2<u32>(at.xy));
}
