// Appended to `intake` with one of the fragments that have `luma_at` and `chroma_at`: Y as it is for a gray image, red, green and
// blue for one of colours (src/yuv.rs), by the weights of the standard in 1/65536.
fn level(sum: i32) -> u32 {
    return u32(clamp((sum + 32768) >> 16u, 0, 255));
}

fn unit_at(x: u32, y: u32) -> u32 {
    let at = vec2(x + dispatch.own.x, y + dispatch.own.y);
    let luma = luma_at(at);
    if FORMAT == GRAY8 {
        return luma;
    }
    let chroma = vec2<i32>(chroma_at(at)) - vec2(128);
    let gray = Y_WEIGHT * (i32(luma) - Y_ZERO);
    let red = level(gray + V_RED * chroma.y);
    let green = level(gray - U_GREEN * chroma.x - V_GREEN * chroma.y);
    return pack(vec4(red, green, level(gray + U_BLUE * chroma.x), 255u));
}
