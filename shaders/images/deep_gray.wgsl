// deep_gray: luma in 16 bits, (9798 R + 19235 G + 3735 B + 16384) >> 15, or a colour.
// source (16-bit samples as uploaded, FORMAT, in a texture) -> gray (u16, eight pixels a vector, 2 gray_stride vectors a
//   row). Value j of a row is column j - 16; the image is continued by its border.
// One invocation: one vector, eight pixels of a row.
// With: samples, bytes, common
// Reference: src/reference/images/gray.rs

@group(0) @binding(3) var<storage, read_write> gray: array<vec4<u32>>;

// The value of the pixel at column x, clamped into the image, of the row that begins at pixel `row`; four of them.
fn four_at(row: u32, x: i32) -> vec4<u32> {
    let start = clamp(x, 0, i32(frame.width) - 1);
    let pixels = four_from(row, u32(start));
    let last = pixels[clamp(i32(frame.width) - 1 - start, 0, 3)];
    let beyond = vec4(x) + vec4(0, 1, 2, 3) >= vec4(i32(frame.width));
    return select(select(pixels, vec4(last), beyond), vec4(pixels.x), vec4(x < 0));
}

// The pixels of a row from a column on; of the mirrored image, if that is what the pass takes.
fn four_from(row: u32, start: u32) -> vec4<u32> {
    let left = min(frame.width - start, 4u);
    let pixels = four_deep(row + select(start, frame.width - start - left, dispatch.own.reversed == 1u));
    let turned = vec4(pixels[left - 1u], pixels[max(left, 2u) - 2u], pixels[max(left, 3u) - 3u], pixels.x);
    return select(pixels, turned, dispatch.own.reversed == 1u);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= 2u * frame.gray_stride || id.y >= dispatch.rows {
        return;
    }
    let row = (dispatch.first_row + id.y) * frame.width;
    let x = 8 * i32(id.x) - 16;
    let a = four_at(row, x);
    let b = four_at(row, x + 4);
    gray[id.y * 2u * frame.gray_stride + id.x] =
        vec4(a.x | (a.y << 16u), a.z | (a.w << 16u), b.x | (b.y << 16u), b.z | (b.w << 16u));
}
