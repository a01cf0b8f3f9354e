// Appended to the kernels that compare features: pixels are compared by their descriptors, too, and both costs have a weight.
@group(0) @binding(5) var<storage, read> left_planes: array<u32>;
@group(0) @binding(6) var<storage, read> right_planes: array<u32>;

fn right_plane_word(start: u32, word: u32) -> u32 {
    return right_planes[start + min(word, frame.right_stride - 1u)];
}

// `column`: of the planes, which begin a block's radius before the image.
fn with_others(angles: vec4<u32>, column: u32, q: u32, row: u32) -> vec4<u32> {
    let j = frame.width - 1u + 2u * frame.block_radius - column + 16u * q;
    let shift = vec4((j & 3u) * 8u);
    let word = j >> 2u;
    var pixel: Pixel;
    var window: Window;
    for (var p = 0u; p < PLANES; p++) {
        let plane_row = p * dispatch.planes_rows + row;
        let own = left_planes[plane_row * frame.left_stride + (column >> 2u)];
        pixel[p] = extractBits(own, (column & 3u) * 8u, 8u) * 0x01010101u;
        let start = plane_row * frame.right_stride;
        let words = vec4(right_plane_word(start, word), right_plane_word(start, word + 1u),
            right_plane_word(start, word + 2u), right_plane_word(start, word + 3u));
        let next = vec4(words.yzw, right_plane_word(start, word + 4u));
        window[p] = (words >> shift) | ((next << vec4(1u)) << (vec4(31u) - shift));
    }
    let others = pixel_costs(pixel, window);
    return vec4(mixed(angles.x, others.x), mixed(angles.y, others.y), mixed(angles.z, others.z),
        mixed(angles.w, others.w));
}

fn mixed(angle: u32, other: u32) -> u32 {
    let weighted = LEARNED_WEIGHT * unpack(angle) + CENSUS_WEIGHT * unpack(other) + vec4(32u);
    return pack(min(weighted >> vec4(6u), vec4(255u)));
}
