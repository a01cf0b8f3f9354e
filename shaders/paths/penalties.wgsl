// penalties: P2 min(P2, max(floor(s P2 / max(delta, s)), P1 + floor(P1 / 2))) and P1 min(P1, max(8, floor(3 P1 / max(delta, 3)))),
//   delta = |I(p) - I(q)| of the gray image I, q the pixel before p in the row, s P2_STEP; P2 and P1 where that lies outside.
// gray (u8, in a texture) -> penalties (PENALTY_BYTES a pixel: u8 P2, then P1; rows of 16 pixels more than the image has)
// One invocation: sixteen pixels of a row. Border: none.
// With: intensity_steps, common
// Reference: src/reference/paths/penalties.rs

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let sixteens = frame.width / 16u + 1u;
    if id.x >= sixteens || id.y >= frame.height {
        return;
    }
    let at = id.y * frame.gray_stride + id.x + 1u; // the first vector lies before the image
    let words = gray_at(at);
    let before = vec4(gray_at(at - 1u).w, words.xyz);
    var bytes: Sixteen;
    for (var i = 0u; i < 4u; i++) {
        let starts = vec4(id.x == 0u && i == 0u, false, false, false);
        put(&bytes, i, unpack(words[i]), unpack((words[i] << 8u) | (before[i] >> 24u)), starts);
    }
    for (var j = 0u; j < PENALTY_BYTES; j++) {
        penalties[(id.y * sixteens + id.x) * PENALTY_BYTES + j] = stored(bytes[j]);
    }
}
