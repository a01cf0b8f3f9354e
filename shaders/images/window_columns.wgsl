// window_columns: sums over the dispatch.own.window rows around a pixel of its column; the first half of window_sums.
// image (u8 or u16, in a texture) -> columns (u32, [y][x])
// One invocation: four columns, SEGMENT rows downwards; a row enters the sum as another leaves it.
// Border: rows are clamped into the image.
// With: gray_pixels, bytes, common
// Reference: src/reference/images/window_sums.rs

struct Own {
    window: u32,        // side of the window
}

@group(0) @binding(3) var<storage, read_write> columns: array<u32>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let x = 4u * id.x;
    let begin = id.y * SEGMENT;
    if x >= frame.width || begin >= frame.height {
        return;
    }
    let radius = i32(dispatch.own.window / 2u);
    let first = i32(begin);
    var sum = vec4(0);
    for (var dy = -radius - 1; dy < radius; dy++) {
        sum += pixels_from(i32(x), first + dy)[0];
    }
    for (var y = first; y < i32(min(begin + SEGMENT, frame.height)); y++) {
        sum += pixels_from(i32(x), y + radius)[0] - pixels_from(i32(x), y - 1 - radius)[0];
        let at = u32(y) * frame.width + x;
        for (var i = 0u; i < 4u; i++) {
            if x + i < frame.width {
                columns[at + i] = u32(sum[i]);
            }
        }
    }
}
