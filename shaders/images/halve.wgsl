// halve: floor((a + b + c + d + 2) / 4) of the pixels (2x, 2y) to (2x + 1, 2y + 1): an image at half the size.
// image (u8, laid out like a gray one, in a texture), of lines x rows pixels -> halved (u8, four pixels a word, laid out
//   like a gray one)
// One invocation: one word. Border: the border pixels are repeated, also in the result.
// With: values, common
// Reference: src/reference/images/halve.rs

@group(0) @binding(2) var image: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(3) var<storage, read_write> halved: array<u32>;

fn value_at(x: u32, y: u32) -> u32 {
    let column = min(x, dispatch.lines - 1u);
    return value_of(textureLoad(image, place_of(column, min(y, dispatch.rows - 1u), dispatch.stride)), column);
}

fn mean(column: i32, y: u32) -> u32 {
    let x = 2u * u32(clamp(column, 0, i32(frame.width) - 1));
    let sum = value_at(x, 2u * y) + value_at(x + 1u, 2u * y) + value_at(x, 2u * y + 1u) + value_at(x + 1u, 2u * y + 1u);
    return (sum + 2u) >> 2u;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= 4u * frame.gray_stride || id.y >= frame.height {
        return;
    }
    let x = 4 * i32(id.x) - 16;
    let four = vec4(mean(x, id.y), mean(x + 1, id.y), mean(x + 2, id.y), mean(x + 3, id.y));
    halved[id.y * 4u * frame.gray_stride + id.x] = pack(four);
}
