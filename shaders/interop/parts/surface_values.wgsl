// How the matcher's buffers are read: in which word of a buffer the value of pixel (x, y) is, and the value in that word.
// `bytes_per_row` is what `MapLayout` says. Appended to `surface_draw` and `surface_store`, and to shaders of other programs.

// Where there is no disparity.
const STEREO_INVALID: i32 = -32768;

// Of a buffer of disparities, two pixels a word.
fn stereo_disparity_word(x: u32, y: u32, bytes_per_row: u32) -> u32 {
    return y * (bytes_per_row / 4u) + x / 2u;
}

// In 1/16 px.
fn stereo_disparity(word: u32, x: u32) -> i32 {
    return extractBits(bitcast<i32>(word), (x & 1u) * 16u, 16u);
}

// Of a buffer of confidences, four pixels a word.
fn stereo_confidence_word(x: u32, y: u32, bytes_per_row: u32) -> u32 {
    return y * (bytes_per_row / 4u) + x / 4u;
}

// From 0, no disparity, to 255.
fn stereo_confidence(word: u32, x: u32) -> u32 {
    return extractBits(word, (x & 3u) * 8u, 8u);
}

// Of a buffer of depths: the word is the depth in micrometres, 0 where there is none.
fn stereo_depth_word(x: u32, y: u32, bytes_per_row: u32) -> u32 {
    return y * (bytes_per_row / 4u) + x;
}

// The number of at most `digits` binary digits that is nearest to n, which is below 2^31; of two the one with an even last digit.
fn stereo_nearest(n: u32, digits: u32) -> u32 {
    let dropped = (max(32u - countLeadingZeros(n), digits) - digits) & 31u;
    let half = (1u << dropped) >> 1u;
    let up = select(0u, half - 1u + ((n >> dropped) & 1u), half > 0u);
    return ((n + up) >> dropped) << dropped;
}

// The metres of a depth in micrometres: the nearest float of so many binary digits, 24 at most. The same bits on every device:
// integers make the digits, and a float of them times a power of two is exact.
fn stereo_rounded_metres(micrometres: u32, digits: u32) -> f32 {
    let zeros = countLeadingZeros(micrometres) & 31u;
    let n = micrometres << zeros;
    let first = (n % 1000000u) << 12u;
    let second = (first % 1000000u) << 3u;
    // n / 1000000 with 15 binary places, and a last one that stands for the rest.
    let rest = select(0u, 1u, second % 1000000u != 0u);
    let quotient = ((n / 1000000u) << 16u) | ((first / 1000000u) << 4u) | ((second / 1000000u) << 1u) | rest;
    return f32(stereo_nearest(quotient, digits)) * bitcast<f32>((111u - zeros) << 23u);
}

// The float nearest to the metres of a depth in micrometres; 0 for 0, which is none.
fn stereo_metres(micrometres: u32) -> f32 {
    return stereo_rounded_metres(micrometres, 24u);
}
