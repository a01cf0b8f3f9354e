// confidence: 0 where the map has no disparity, else the margin of the pixel's winner over its best rival, at least 1.
// map (i16), margins (u16, behind the right map) -> confidence (u8)
// One invocation: eight pixels of a row. Border: none.
// With: common
// Reference: src/reference/filters/confidence.rs

@group(0) @binding(2) var<storage, read> map: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> right_map: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> confidence: array<vec2<u32>>;

// A byte for each half of the words.
fn of_halves(values: vec4<u32>, margins: vec4<u32>) -> vec4<u32> {
    return select(max(margins, vec4(1u)), vec4(0u), values == vec4(bitcast<u32>(INVALID) & 0xffffu));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= frame.height {
        return;
    }
    let at = id.y * stride + id.x;
    let values = map[at];
    let margins = right_map[frame.map_words / 4u + at];
    let low = of_halves(values & vec4(0xffffu), margins & vec4(0xffffu));
    let high = of_halves(values >> vec4(16u), margins >> vec4(16u));
    let pairs = low | (high << vec4(8u));
    confidence[at] = pairs.xz | (pairs.yw << vec2(16u));
}
