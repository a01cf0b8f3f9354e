// Appended to `intake` where the pixels are a buffer's: dispatch.stride words a row.
@group(0) @binding(3) var<storage, read> image: array<u32>;

fn unit_at(x: u32, y: u32) -> u32 {
    let at = x + dispatch.own.x * UNITS_A_PIXEL;
    return extractBits(image[(y + dispatch.own.y) * dispatch.stride + at / IN_WORD], at % IN_WORD * BITS, BITS);
}
