// mi_histogram: how often a left pixel of value l matches a right one of value r, according to the map of the round before.
// left, right (u8, laid out like a gray image, in textures), map (i16, of images halved `halvings` times more often,
//   `stride` words a row) -> counts (u32, [l][r], 0 before)
// One invocation: one left pixel. Pixels without a disparity, or whose match lies outside, do not count.
// With: values, common
// Reference: src/reference/cost/mi_histogram.rs

struct Own {
    halvings: u32,      // of the images of the map, beyond those of the images at hand
}

@group(0) @binding(2) var left: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(3) var right: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(4) var<storage, read> map: array<u32>;
@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width || id.y >= frame.height {
        return;
    }
    let column = id.x >> dispatch.own.halvings;
    let value = map_value(map[(id.y >> dispatch.own.halvings) * dispatch.stride + (column >> 1u)], column);
    let seen = i32(id.x) - ((value * i32(1u << dispatch.own.halvings) + 8) >> 4u);
    if value == INVALID || seen < 0 || seen >= i32(frame.width) {
        return;
    }
    let x = u32(seen);
    let l = value_of(textureLoad(left, place_of(id.x, id.y, frame.gray_stride)), id.x);
    let r = value_of(textureLoad(right, place_of(x, id.y, frame.gray_stride)), x);
    atomicAdd(&counts[l * 256u + r], 1u);
}
