// Appended to the kernels that read values of the network: texels of four channels each, laid line by line into a texture TEXELS
// wide, block by block, [block of channels][plane][row][column]. The planes of an image are the two sides.
@group(0) @binding(2) var values: texture_storage_2d<rgba32uint, read>;

fn value_at(at: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(textureLoad(values, vec2(at % TEXELS, at / TEXELS)));
}
