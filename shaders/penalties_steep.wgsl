// penalties_steep: min(P2, max(floor(10 P2 / max(delta, 10)), P1 + floor(P1 / 2))), delta = |I(p) - I(q)| of the gray image I,
//   q the pixel before p in each of the directions (1, 2), (-1, 2), (2, 1), (-2, 1).
// gray (u8, in a texture) -> penalties (u8, four directions a word, a word a pixel, rows of whole vectors of 16 pixels)
// One invocation: sixteen pixels of a row. Border: the image is continued by it.
// Reference: src/reference/penalties.rs

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let vectors = (frame.width + 15u) / 16u;
    if id.x >= vectors || id.y >= frame.height {
        return;
    }
    let row = pixels_at(id.x, id.y);
    let above = pixels_at(id.x, id.y - min(id.y, 1u));
    let second_above = pixels_at(id.x, id.y - min(id.y, 2u));
    for (var i = 0u; i < 4u; i++) {
        let here = unpack(row[i + 1u]);
        penalties[(id.y * vectors + id.x) * 4u + i] = penalty(here, neighbours(second_above, i, 1))
            | (penalty(here, neighbours(second_above, i, -1)) << vec4(8u))
            | (penalty(here, neighbours(above, i, 2)) << vec4(16u))
            | (penalty(here, neighbours(above, i, -2)) << vec4(24u));
    }
}
