// mirror: a map with each row reversed.
// map (i16) -> mirrored (i16)
// One invocation: four words, eight pixels of a row. Border: what lies beyond a row is its last pixel, and never used.
// With: common
// Reference: src/reference/winner/mirror.rs

@group(0) @binding(2) var<storage, read> map: array<u32>;
@group(0) @binding(3) var<storage, read_write> mirrored: array<vec4<u32>>;

fn value(x: u32, row: u32) -> i32 {
    let opposite = frame.width - 1u - min(x, frame.width - 1u);
    return map_value(map[row * frame.map_stride + (opposite >> 1u)], opposite);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    var words: vec4<u32>;
    for (var i = 0u; i < 4u; i++) {
        let x = 8u * id.x + 2u * i;
        words[i] = map_word(value(x, id.y), value(x + 1u, id.y));
    }
    mirrored[id.y * stride + id.x] = words;
}
