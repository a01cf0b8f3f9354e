// gray: luma in 8 bits, (9798 R + 19235 G + 3735 B + 16384) >> 15; 16-bit samples end as (v + 128) / 257.
// source (samples as uploaded, FORMAT) -> gray (u8, sixteen pixels a vector, gray_stride vectors a row)
//   Byte j of a row is column j - 16; the image is continued by its border, so that the prefilter needs no clamping.
// One invocation: one vector, sixteen pixels of a row.
// Reference: src/reference/gray.rs

@group(0) @binding(2) var<storage, read> source: array<u32>;
@group(0) @binding(3) var<storage, read_write> gray: array<vec4<u32>>;

fn luma(r: u32, g: u32, b: u32) -> u32 {
    return (9798u * r + 19235u * g + 3735u * b + 16384u) >> 15u;
}

fn narrow(v: u32) -> u32 {
    return (v + 128u) / 257u;
}

// Sixteen pixels beyond a border are asked for, and not used.
fn word(i: u32) -> u32 {
    return source[min(i, arrayLength(&source) - 1u)];
}

fn pixel(p: u32) -> u32 {
    switch FORMAT {
        case GRAY8: { return extractBits(word(p >> 2u), (p & 3u) * 8u, 8u); }
        case GRAY16: { return narrow(extractBits(word(p >> 1u), (p & 1u) * 16u, 16u)); }
        case RGBA8: {
            let s = unpack(word(p));
            return luma(s.x, s.y, s.z);
        }
        default: {
            let rg = word(2u * p);
            return narrow(luma(rg & 0xffffu, rg >> 16u, word(2u * p + 1u) & 0xffffu));
        }
    }
}

fn four_pixels(p: u32) -> u32 {
    return pack(vec4(pixel(p), pixel(p + 1u), pixel(p + 2u), pixel(p + 3u)));
}

fn sixteen_pixels(p: u32) -> vec4<u32> {
    if FORMAT == GRAY8 {
        let i = p >> 2u;
        let first = vec4(word(i), word(i + 1u), word(i + 2u), word(i + 3u));
        return from_byte(first, word(i + 4u), p);
    }
    return vec4(four_pixels(p), four_pixels(p + 4u), four_pixels(p + 8u), four_pixels(p + 12u));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.gray_stride || id.y >= frame.height {
        return;
    }
    let row = id.y * frame.width;
    let x = 16 * i32(id.x) - 16;
    let inside = low_bytes(select(i32(frame.width) - x, 0, x < 0));
    let border = vec4(pixel(row + select(frame.width - 1u, 0u, x < 0)) * 0x01010101u);
    gray[id.y * frame.gray_stride + id.x] = select_bits(border, sixteen_pixels(row + u32(x)), inside);
}
