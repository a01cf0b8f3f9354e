// Appended to `surface_draw` and `surface_store`: the colour of the disparity, black where there is none.
alias Shown = vec4<f32>;

@group(0) @binding(2) var<storage, read> map: array<u32>;
// Of each 1/16 px from the smallest disparity on (src/color.rs); a colour is four bytes.
@group(0) @binding(3) var<storage, read> colors: array<u32>;

fn shown_at(at: vec2<u32>) -> Shown {
    let value = stereo_disparity(map[stereo_disparity_word(at.x, at.y, 4u * frame.map_stride)], at.x);
    let index = clamp(value - 16 * frame.min_disparity, 0, i32(arrayLength(&colors)) - 1);
    return select(vec4<f32>(unpack(colors[index])) / 255.0, vec4(0.0, 0.0, 0.0, 1.0), value == STEREO_INVALID);
}
