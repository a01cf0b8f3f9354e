// depth: floor(product / (256 v + offset)) of a map value v: focal * baseline / (disparity + doffs) in millionths.
// map (i16) -> depth (u32, a word a pixel; 0: none)
// One invocation: two words of the map, four pixels of a row.
// Border: none. No depth: no disparity, a divisor below 1, a quotient beyond 32 bits.
// With: common
// Reference: src/reference/filters/depth.rs

@group(0) @binding(2) var<storage, read> map: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> depth: array<vec4<u32>>;

// The quotients bit by bit, of divisors above the high word of the product and below 2^29.
fn quotients(divisors: vec4<u32>) -> vec4<u32> {
    var rests = vec4(frame.depth_high);
    var found = vec4(0u);
    for (var i = 0u; i < 32u; i++) {
        rests = (rests << vec4(1u)) | vec4((frame.depth_low >> (31u - i)) & 1u);
        let fit = rests >= divisors;
        rests -= select(vec4(0u), divisors, fit);
        found = (found << vec4(1u)) | select(vec4(0u), vec4(1u), fit);
    }
    return found;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 2u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let at = id.y * stride + id.x;
    let words = map[at];
    let values = vec4(map_value(words.x, 0u), map_value(words.x, 1u), map_value(words.y, 0u), map_value(words.y, 1u));
    let divisors = 256 * values + vec4(frame.depth_offset);
    let near = vec4<u32>(max(divisors, vec4(0))) > vec4(frame.depth_high);
    depth[at] = select(vec4(0u), quotients(vec4<u32>(divisors)), near & (divisors > vec4(0)) & (values != vec4(INVALID)));
}
