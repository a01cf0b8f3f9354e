// intake: the caller's pixels become those of an uploaded image: rows of samples without padding, 16 bytes a texel.
// a texture or a buffer (`unit_at` of `intake_texture`, `intake_buffer` or `intake_yuv`) -> source (rgba32uint)
//   A unit is a pixel, or half of one of 8 bytes: BITS. Pixel (0, 0) is (dispatch.own.x, dispatch.own.y) of the caller's.
// One invocation: one texel. Behind the last pixel: zeros.
// With: common
// Chosen: intake_*
// Reference: src/image.rs, src/yuv.rs

struct Own {
    x: u32,
    y: u32,
    chroma_stride: u32,
}

@group(0) @binding(2) var source: texture_storage_2d<rgba32uint, write>;

const UNITS: u32 = 128u / BITS; // a texel
const IN_WORD: u32 = 32u / BITS;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = frame.width * UNITS_A_PIXEL;
    let first = ((id.y << (frame.source_shift & 31u)) + id.x) * UNITS;
    var y = first / row;
    if y >= frame.height {
        return;
    }
    var x = first - y * row;
    var words = vec4<u32>();
    for (var i = 0u; i < UNITS; i++) {
        if y < frame.height {
            words[i / IN_WORD] |= unit_at(x, y) << (i % IN_WORD * BITS);
        }
        x += 1u;
        if x == row {
            x = 0u;
            y += 1u;
        }
    }
    textureStore(source, id.xy, words);
}
