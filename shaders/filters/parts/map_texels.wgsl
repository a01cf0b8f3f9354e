// Appended to the filters that read eight pixels of a map at a time from a texture, and write them to a buffer.

@group(0) @binding(2) var map: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(3) var<storage, read_write> filtered: array<vec4<u32>>;

fn map_at(index: u32) -> vec4<u32> {
    return textureLoad(map, vec2(index % TEXELS, index / TEXELS));
}

// Of the columns x, x + 2, x + 4 and x + 6.
fn even_values(words: vec4<u32>) -> vec4<i32> {
    return bitcast<vec4<i32>>(words << vec4(16u)) >> vec4(16u);
}

// Of the columns x + 1, x + 3, x + 5 and x + 7.
fn odd_values(words: vec4<u32>) -> vec4<i32> {
    return bitcast<vec4<i32>>(words) >> vec4(16u);
}

fn map_words(even: vec4<i32>, odd: vec4<i32>) -> vec4<u32> {
    return (bitcast<vec4<u32>>(even) & vec4(0xffffu)) | (bitcast<vec4<u32>>(odd) << vec4(16u));
}
