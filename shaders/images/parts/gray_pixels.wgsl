// Appended to the kernels that read an image that `gray` or `deep_gray` left, or one laid out like that.
@group(0) @binding(2) var image: texture_storage_2d<rgba32uint, read>;

// Twenty neighbouring pixels of a row.
alias Pixels = array<vec4<i32>, 5>;

fn image_at(index: u32) -> vec4<u32> {
    return textureLoad(image, vec2(index % TEXELS, index / TEXELS));
}

// The texel that holds byte `first` of the row that begins at texel `row`. Bytes before the row repeat its first pixel.
fn first_texel(row: u32, first: i32) -> vec4<u32> {
    let texel = image_at(row + u32(max(first, 0)) / 16u);
    let pixel = select((texel.x & 255u) * 0x01010101u, (texel.x & 0xffffu) * 0x10001u, DEEP == 1u);
    return select(texel, vec4(pixel), first < 0);
}

fn bytes_of(word: u32) -> vec4<i32> {
    return vec4<i32>(unpack(word));
}

// Two words of 16-bit values, which begin `odd` values later; `next` is the word after them.
fn halves_of(words: vec2<u32>, next: u32, odd: bool) -> vec4<i32> {
    let shifted = select(words, (words >> vec2(16u)) | (vec2(words.y, next) << vec2(16u)), vec2(odd));
    return vec4<i32>(vec4(shifted.x & 0xffffu, shifted.x >> 16u, shifted.y & 0xffffu, shifted.y >> 16u));
}

// The pixels from column x on, which is -24 or more; rows are clamped into the image.
fn pixels_from(x: i32, y: i32) -> Pixels {
    let first = u32(x + 16);
    let row = u32(clamp(y, 0, i32(frame.height) - 1));
    if DEEP == 1u {
        let start = row * 2u * frame.gray_stride;
        let at = start + u32((x + 16) >> 3u);
        let texels = array(first_texel(start, 2 * (x + 16)), image_at(at + 1u), image_at(at + 2u), image_at(at + 3u));
        let a = from_word(texels[0], texels[1], first >> 1u);
        let b = from_word(texels[1], texels[2], first >> 1u);
        let c = from_word(texels[2], texels[3], first >> 1u);
        let odd = (first & 1u) == 1u;
        return Pixels(halves_of(a.xy, a.z, odd), halves_of(a.zw, b.x, odd), halves_of(b.xy, b.z, odd),
            halves_of(b.zw, c.x, odd), halves_of(c.xy, c.z, odd));
    }
    let start = row * frame.gray_stride;
    let at = start + u32((x + 16) >> 4u);
    let texels = array(first_texel(start, x + 16), image_at(at + 1u), image_at(at + 2u));
    let a = from_word(texels[0], texels[1], first >> 2u);
    let b = from_word(texels[1], texels[2], first >> 2u);
    let words = from_byte(a, b.x, first);
    return Pixels(bytes_of(words.x), bytes_of(words.y), bytes_of(words.z), bytes_of(words.w),
        bytes_of(from_byte(b, 0u, first).x));
}

// In units of one of 256 levels, the nearest one, halves upwards; |v| < 2^20.
fn in_levels(v: vec4<i32>) -> vec4<i32> {
    if DEEP == 0u {
        return v;
    }
    return vec4<i32>(vec4<u32>(v + vec4(128 + 257 * 4096)) / vec4(257u)) - vec4(4096);
}

// The 3x3 Sobel derivative to the right of four pixels, from three rows of the eight that begin one column before them.
fn sobel_x(above: Pixels, here: Pixels, below: Pixels, i: u32) -> vec4<i32> {
    let left = above[i] + 2 * here[i] + below[i];
    let next = above[i + 1u].xy + 2 * here[i + 1u].xy + below[i + 1u].xy;
    return in_levels(vec4(left.zw, next) - left);
}

// The same downwards.
fn sobel_y(above: Pixels, below: Pixels, i: u32) -> vec4<i32> {
    let down = below[i] - above[i];
    let down_next = below[i + 1u].xy - above[i + 1u].xy;
    return in_levels(down + 2 * vec4(down.yzw, down_next.x) + vec4(down.zw, down_next));
}

// floor(v / n) in units of one of 256 levels, clamped into -128 .. 127; n < 2^16.
fn mean_in_levels(v: vec4<i32>, n: i32) -> vec4<i32> {
    if DEEP == 1u {
        return clamped_quotient(v, 257 * n);
    }
    return clamped_quotient(v, n);
}

fn clamped_quotient(v: vec4<i32>, divisor: i32) -> vec4<i32> {
    let positive = clamp(v, vec4(-128 * divisor), vec4(128 * divisor - 1)) + vec4(128 * divisor);
    return vec4<i32>(vec4<u32>(positive) / vec4(u32(divisor))) - vec4(128);
}
