// surface_store: the value that `shown_at` gives for each pixel, stored in the caller's texture, which cannot be drawn to.
// One invocation: one pixel.
// With: common
// Chosen: surface_*
// Reference: src/color.rs, src/image.rs

@group(0) @binding(4) var shown: Target;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < frame.width && id.y < frame.height {
        textureStore(shown, id.xy, shown_at(id.xy));
    }
}
