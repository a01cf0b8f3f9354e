// Appended to the kernels that read uploaded images: their bytes, and luma.

struct Own {
    channel: u32,    // 0: luma, 1 to 3: red, green, blue
    reversed: u32,   // 1: the images are taken mirrored
}

@group(0) @binding(2) var source: texture_storage_2d<rgba32uint, read>;

fn luma(r: vec4<u32>, g: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
    return (9798u * r + 19235u * g + 3735u * b + 16384u) >> vec4(15u);
}

// Luma, or one of the colours.
fn channel(r: vec4<u32>, g: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
    switch dispatch.own.channel {
        case 1u: {
            return r;
        }
        case 2u: {
            return g;
        }
        case 3u: {
            return b;
        }
        default: {
            return luma(r, g, b);
        }
    }
}

fn source_at(index: u32) -> vec4<u32> {
    let shift = frame.source_shift & 31u;
    return textureLoad(source, vec2(index & ((1u << shift) - 1u), index >> shift));
}

fn sixteen_bytes(byte: u32) -> vec4<u32> {
    let at = byte >> 4u;
    let a = source_at(at);
    let b = source_at(at + 1u);
    let c = source_at(at + 2u);
    return from_byte(from_word(a, b, byte >> 2u), from_word(b, c, byte >> 2u).x, byte);
}

// Four samples of 16 bits.
fn four_deep(p: u32) -> vec4<u32> {
    if FORMAT == GRAY16 {
        let s = sixteen_bytes(2u * p);
        return vec4(s.x & 0xffffu, s.x >> 16u, s.y & 0xffffu, s.y >> 16u);
    }
    let s = sixteen_bytes(8u * p);
    let t = sixteen_bytes(8u * p + 16u);
    let rg = vec4(s.xz, t.xz);
    return channel(rg & vec4(0xffffu), rg >> vec4(16u), vec4(s.yw, t.yw) & vec4(0xffffu));
}
