// rectify: the mean of the four source samples around a position, weighted in 1/256 px: (sum of weight * sample + 2^15) >> 16.
// source (samples as uploaded, FORMAT, in a texture), positions (1/256 px, column and row a pixel) -> rectified (as source)
// One invocation: sixteen bytes. Behind the last pixel: zeros.
// Border: outside the source all samples are 0.
// With: common
// Reference: src/reference/images/rectify.rs

@group(0) @binding(2) var source: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(3) var<storage, read> positions: array<vec2<i32>>;
@group(0) @binding(4) var<storage, read_write> rectified: array<vec4<u32>>;

// Bits of a sample, samples of a pixel and of a word.
const BITS: u32 = 8u + 8u * DEEP;
const COUNT: u32 = select(4u, 1u, FORMAT == GRAY8 || FORMAT == GRAY16);
const IN_WORD: u32 = 32u / BITS;

fn sample(x: i32, y: i32, channel: u32) -> u32 {
    let inside = x >= 0 && y >= 0 && x < i32(frame.width) && y < i32(frame.height);
    let pixel = select(0u, u32(y) * frame.width + u32(x), inside);
    let i = pixel * COUNT + channel;
    let word = i / IN_WORD;
    let texel = word / 4u;
    let shift = frame.source_shift & 31u;
    let words = textureLoad(source, vec2(texel & ((1u << shift) - 1u), texel >> shift));
    let two = select(words.xy, words.zw, (word & 2u) != 0u);
    let found = extractBits(select(two.x, two.y, (word & 1u) != 0u), i % IN_WORD * BITS, BITS);
    return select(0u, found, inside);
}

fn blend(position: vec2<i32>, channel: u32) -> u32 {
    let part = vec2<u32>(position & vec2(255));
    let at = position >> vec2(8u);
    let above = (256u - part.x) * sample(at.x, at.y, channel) + part.x * sample(at.x + 1, at.y, channel);
    let below = (256u - part.x) * sample(at.x, at.y + 1, channel) + part.x * sample(at.x + 1, at.y + 1, channel);
    return ((256u - part.y) * above + part.y * below + 32768u) >> 16u;
}

fn word_of(first: u32) -> u32 {
    var word = 0u;
    for (var i = 0u; i < IN_WORD; i++) {
        let pixel = (first + i) / COUNT;
        let inside = pixel < frame.width * frame.height;
        let value = blend(positions[select(0u, pixel, inside)], (first + i) % COUNT);
        word |= select(0u, value, inside) << (i * BITS);
    }
    return word;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = (id.y << (frame.source_shift & 31u)) + id.x;
    if id.x >= 1u << (frame.source_shift & 31u) {
        return;
    }
    let first = index * 4u * IN_WORD;
    rectified[index] = vec4(
        word_of(first), word_of(first + IN_WORD), word_of(first + 2u * IN_WORD), word_of(first + 3u * IN_WORD));
}
