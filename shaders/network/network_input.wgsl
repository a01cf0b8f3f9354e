// network_input: red, green and blue between 0 and 1, minus their mean, divided by their deviation; a gray image has three equal ones.
// source (samples as uploaded, FORMAT, in a texture) -> values (f32, [side][row][column][channel], the fourth channel 0)
//   Rows of padding lie above the image, columns of padding to the right of it.
// One invocation: a pixel.
// Border: padding is 0.
// With: samples, bytes, common
// Reference: src/reference/network/input.rs

@group(0) @binding(3) var<storage, read_write> result: array<vec4<f32>>;

// Red, green and blue between 0 and 1.
fn colors(p: u32) -> vec3<f32> {
    if FORMAT == GRAY8 {
        return vec3(f32(sixteen_bytes(p).x & 255u) / 255.0);
    }
    if FORMAT == GRAY16 {
        return vec3(f32(sixteen_bytes(2u * p).x & 0xffffu) / 65535.0);
    }
    if FORMAT == RGBA8 {
        return vec3<f32>(unpack(sixteen_bytes(4u * p).x).xyz) / 255.0;
    }
    let s = sixteen_bytes(8u * p).xy;
    return vec3(f32(s.x & 0xffffu), f32(s.x >> 16u), f32(s.y & 0xffffu)) / 65535.0;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let columns = dispatch.stride;
    if id.x >= columns {
        return;
    }
    let padding = dispatch.rows - frame.height;
    var value = vec4(0.0);
    if id.x < frame.width && id.y >= padding {
        let x = select(id.x, frame.width - 1u - id.x, dispatch.own.reversed == 1u);
        let color = colors((id.y - padding) * frame.width + x);
        value = vec4((color - vec3(0.485, 0.456, 0.406)) / vec3(0.229, 0.224, 0.225), 0.0);
    }
    result[dispatch.slot + id.y * columns + id.x] = value;
}
