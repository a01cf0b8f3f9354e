// Appended to the kernels that compare pixels: the entry of the table of `mi_table` for two values, four entries a texel.
@group(0) @binding(5) var table: texture_storage_2d<r32uint, read>;

fn pixel_costs(left: Pixel, right: Window) -> vec4<u32> {
    let l = left[0] & 255u;
    return vec4(looked_up(l, right[0].x), looked_up(l, right[0].y), looked_up(l, right[0].z), looked_up(l, right[0].w));
}

fn looked_up(l: u32, rights: u32) -> u32 {
    let r = unpack(rights);
    let columns = r >> vec4(2u);
    let words = vec4(textureLoad(table, vec2(columns.x, l)).x, textureLoad(table, vec2(columns.y, l)).x,
        textureLoad(table, vec2(columns.z, l)).x, textureLoad(table, vec2(columns.w, l)).x);
    return pack((words >> ((r & vec4(3u)) * 8u)) & vec4(255u));
}
