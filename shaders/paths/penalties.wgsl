// penalties: min(P2, max(floor(10 P2 / max(delta, 10)), P1 + floor(P1 / 2))), delta = |I(p) - I(q)| of the gray image I,
//   q the pixel before p in the row; P2 where that lies outside.
// gray (u8, in a texture) -> penalties (u8, rows of a vector more than the image has)
// One invocation: sixteen pixels of a row. Border: none.
// With: intensity_steps, common
// Reference: src/reference/paths/penalties.rs

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let vectors = frame.width / 16u + 1u;
    if id.x >= vectors || id.y >= frame.height {
        return;
    }
    let at = id.y * frame.gray_stride + id.x + 1u; // the first vector lies before the image
    let words = gray_at(at);
    let before = vec4(gray_at(at - 1u).w, words.xyz);
    var bytes = vec4(0u);
    for (var i = 0u; i < 4u; i++) {
        bytes[i] = pack(penalty(unpack(words[i]), unpack((words[i] << 8u) | (before[i] >> 24u))));
    }
    if id.x == 0u {
        bytes.x = (bytes.x & 0xffffff00u) | frame.p2;
    }
    penalties[id.y * vectors + id.x] = stored(bytes);
}
