// gray: luma in 8 bits, (9798 R + 19235 G + 3735 B + 16384) >> 15; 16-bit samples end as (v + 128) / 257.
// source (samples as uploaded, FORMAT) -> gray (u8, four pixels a word, gray_stride words a row)
// One invocation: one word, four pixels of a row. Pixels beyond the row repeat its last one.
// Reference: src/reference/gray.rs

@group(0) @binding(2) var<storage, read> source: array<u32>;
@group(0) @binding(3) var<storage, read_write> gray: array<u32>;

fn luma(r: u32, g: u32, b: u32) -> u32 {
    return (9798u * r + 19235u * g + 3735u * b + 16384u) >> 15u;
}

fn narrow(v: u32) -> u32 {
    return (v + 128u) / 257u;
}

fn pixel(p: u32) -> u32 {
    switch FORMAT {
        case GRAY8: { return extractBits(source[p >> 2u], (p & 3u) * 8u, 8u); }
        case GRAY16: { return narrow(extractBits(source[p >> 1u], (p & 1u) * 16u, 16u)); }
        case RGBA8: {
            let s = unpack(source[p]);
            return luma(s.x, s.y, s.z);
        }
        default: {
            let rg = source[2u * p];
            return narrow(luma(rg & 0xffffu, rg >> 16u, source[2u * p + 1u] & 0xffffu));
        }
    }
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.gray_stride || id.y >= frame.height {
        return;
    }
    let row = id.y * frame.width;
    let x = min(vec4(4u * id.x) + vec4(0u, 1u, 2u, 3u), vec4(frame.width - 1u));
    gray[id.y * frame.gray_stride + id.x] =
        pack(vec4(pixel(row + x.x), pixel(row + x.y), pixel(row + x.z), pixel(row + x.w)));
}
