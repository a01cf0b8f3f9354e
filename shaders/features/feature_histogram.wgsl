// feature_histogram: how many pixels of an image have each value, in bins of 64 of 65536 levels.
// image (u8 or u16, in a texture) -> counts (u32, of 1024 bins, 0 before)
// One invocation: four pixels of a row.
// With: gray_pixels, bytes, common
// Reference: src/reference/features/feature_statistics.rs

@group(0) @binding(3) var<storage, read_write> counts: array<atomic<u32>>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let x = 4u * id.x;
    if x >= frame.width || id.y >= frame.height {
        return;
    }
    let values = vec4<u32>(pixels_from(i32(x), i32(id.y))[0]);
    var bins = select(4u * values, values >> vec4(6u), vec4(DEEP == 1u));
    for (var i = 0u; i < 4u; i++) {
        if x + i < frame.width {
            atomicAdd(&counts[bins[i]], 1u);
        }
    }
}
