// Appended to the kernels that write planes: where sixteen pixels of a row lie in one.
// Byte j of a row is column j - lead, or if it is mirrored column lead - j; columns beyond the border repeat it.

struct Own {
    mirrored: u32,      // 1: columns of a plane run to the left
    lead: i32,          // the column of a plane's first byte, to the left or from where columns run to the left
    first_plane: u32,   // the plane that is written, or the first one
}

// The lowest column of a vector of a row. At least one of its sixteen must lie in the image.
fn lowest_column(vector: u32, mirrored: bool) -> i32 {
    let j = 16 * i32(vector);
    return clamp(select(j - dispatch.own.lead, dispatch.own.lead - j - 15, mirrored), -15, i32(frame.width) - 1);
}

// Sixteen pixels from column x on, as they are written.
fn laid_out(pixels: vec4<u32>, x: i32, mirrored: bool) -> vec4<u32> {
    let last = i32(frame.width) - 1;
    var words = select_bits(pixels, byte_at(pixels, -x), low_bytes(-x));
    words = select_bits(byte_at(words, last - x), words, low_bytes(last - x));
    return select(words, reversed(words), vec4(mirrored));
}

fn reversed(words: vec4<u32>) -> vec4<u32> {
    let w = words.wzyx;
    return vec4(pack(unpack(w.x).wzyx), pack(unpack(w.y).wzyx), pack(unpack(w.z).wzyx), pack(unpack(w.w).wzyx));
}
