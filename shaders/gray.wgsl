// gray: luma in 8 bits, (9798 R + 19235 G + 3735 B + 16384) >> 15; 16-bit samples end as (v + 128) / 257.
// source (samples as uploaded, FORMAT, in a texture) -> gray (u8, sixteen pixels a vector, gray_stride vectors a row)
//   Byte j of a row is column j - 16; the image is continued by its border, so that the prefilter needs no clamping.
// One invocation: one vector, sixteen pixels of a row.
// Reference: src/reference/gray.rs

@group(0) @binding(2) var source: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(3) var<storage, read_write> gray: array<vec4<u32>>;

fn luma(r: vec4<u32>, g: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
    return (9798u * r + 19235u * g + 3735u * b + 16384u) >> vec4(15u);
}

fn narrow(v: vec4<u32>) -> vec4<u32> {
    return (v + 128u) / 257u;
}

fn source_at(index: u32) -> vec4<u32> {
    return textureLoad(source, vec2(index % TEXELS, index / TEXELS));
}

fn sixteen_bytes(byte: u32) -> vec4<u32> {
    let at = byte >> 4u;
    let a = source_at(at);
    let b = source_at(at + 1u);
    let c = source_at(at + 2u);
    return from_byte(from_word(a, b, byte >> 2u), from_word(b, c, byte >> 2u).x, byte);
}

fn four_pixels(p: u32) -> u32 {
    switch FORMAT {
        case GRAY16: {
            let s = sixteen_bytes(2u * p);
            return pack(narrow(vec4(s.x & 0xffffu, s.x >> 16u, s.y & 0xffffu, s.y >> 16u)));
        }
        case RGBA8: {
            let s = sixteen_bytes(4u * p);
            return pack(luma(s & vec4(255u), (s >> vec4(8u)) & vec4(255u), (s >> vec4(16u)) & vec4(255u)));
        }
        default: {
            let s = sixteen_bytes(8u * p);
            let t = sixteen_bytes(8u * p + 16u);
            let rg = vec4(s.xz, t.xz);
            return pack(narrow(luma(rg & vec4(0xffffu), rg >> vec4(16u), vec4(s.yw, t.yw) & vec4(0xffffu))));
        }
    }
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
    let first = select(start, frame.width - start - left, pass_.mirrored == 1u);
    let pixels = sixteen_pixels(row + first);
    let reversed = vec4(turned(pixels.w), turned(pixels.z), turned(pixels.y), turned(pixels.x));
    // Of the last pixels of a mirrored row, others were read before them.
    let skip = 16u - left;
    let words = from_word(reversed, reversed, skip >> 2u);
    return select(pixels, from_byte(words, words.x, skip), pass_.mirrored == 1u);
}

// The bytes of a word in the other order.
fn turned(word: u32) -> u32 {
    return pack(unpack(word).wzyx);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.gray_stride || id.y >= frame.height {
        return;
    }
    let row = id.y * frame.width;
    let x = 16 * i32(id.x) - 16;
    // Where no column or not all of them lie in the image, others are read in their place and not used.
    let start = clamp(x, 0, i32(frame.width) - 1);
    let inside = select(i32(frame.width) - start, 1, x < 0);
    let pixels = pixels_from(row, u32(start));
    gray[id.y * frame.gray_stride + id.x] =
        select_bits(byte_at(pixels, inside - 1), pixels, low_bytes(inside));
}
