// gray: luma in 8 bits, (9798 R + 19235 G + 3735 B + 16384) >> 15, or a colour; 16-bit samples end as (v + 128) / 257.
// source (samples as uploaded, FORMAT, in a texture) -> gray (u8, sixteen pixels a vector, gray_stride vectors a row)
//   Byte j of a row is column j - 16; the image is continued by its border, so that what follows needs no clamping.
// One invocation: one vector, sixteen pixels of a row.
// With: samples, bytes, common
// Reference: src/reference/images/gray.rs

@group(0) @binding(3) var<storage, read_write> gray: array<vec4<u32>>;

fn four_pixels(p: u32) -> u32 {
    if FORMAT == RGBA8 {
        let s = sixteen_bytes(4u * p);
        return pack(channel(s & vec4(255u), (s >> vec4(8u)) & vec4(255u), (s >> vec4(16u)) & vec4(255u)));
    }
    return pack((four_deep(p) + 128u) / 257u);
}

fn sixteen_pixels(p: u32) -> vec4<u32> {
    if FORMAT == GRAY8 {
        return sixteen_bytes(p);
    }
    return vec4(four_pixels(p), four_pixels(p + 4u), four_pixels(p + 8u), four_pixels(p + 12u));
}

// The pixels of a row from a column on; of the mirrored image, if that is what the pass takes.
fn pixels_from(row: u32, start: u32) -> vec4<u32> {
    let left = min(frame.width - start, 16u);
    let first = select(start, frame.width - start - left, dispatch.own.reversed == 1u);
    let pixels = sixteen_pixels(row + first);
    let reversed = vec4(turned(pixels.w), turned(pixels.z), turned(pixels.y), turned(pixels.x));
    // Of the last pixels of a mirrored row, others were read before them.
    let skip = 16u - left;
    let words = from_word(reversed, reversed, skip >> 2u);
    return select(pixels, from_byte(words, words.x, skip), dispatch.own.reversed == 1u);
}

// The bytes of a word in the other order.
fn turned(word: u32) -> u32 {
    return pack(unpack(word).wzyx);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.gray_stride || id.y >= dispatch.rows {
        return;
    }
    let row = (dispatch.first_row + id.y) * frame.width;
    let x = 16 * i32(id.x) - 16;
    // For columns outside the image, other samples are read and ignored.
    let start = clamp(x, 0, i32(frame.width) - 1);
    let inside = select(i32(frame.width) - start, 1, x < 0);
    let pixels = pixels_from(row, u32(start));
    gray[id.y * frame.gray_stride + id.x] =
        select_bits(byte_at(pixels, inside - 1), pixels, low_bytes(inside));
}
