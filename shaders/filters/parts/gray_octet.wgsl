// Appended to the kernels that read the left image's gray beside the map, eight pixels at a time.

@group(0) @binding(4) var gray: texture_storage_2d<rgba32uint, read>;

// Of eight columns from 8 i on, in the gray image's row: its vectors hold sixteen, from column -16 on.
fn gray_words(row: u32, i: u32) -> vec2<u32> {
    let index = row * frame.gray_stride + i / 2u;
    let words = textureLoad(gray, vec2(index % TEXELS, index / TEXELS));
    return select(words.xy, words.zw, (i & 1u) == 1u);
}
