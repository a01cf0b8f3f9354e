// Appended to the kernels that carry a value with the gray of its pixel, as a key: the value, above invalid, which is 0, over
// the gray; 0 where the pixel is invalid. Eight neighbouring keys lie in the order of their columns.

struct Keys {
    low: vec4<u32>,
    high: vec4<u32>,
}

fn keys_of_four(values: vec4<i32>, grays: u32) -> vec4<u32> {
    let keys = ((bitcast<vec4<u32>>(values) ^ vec4(0x8000u)) << vec4(16u)) | unpack(grays);
    return select(keys, vec4(0u), values == vec4(INVALID));
}

fn keys_of(even: vec4<i32>, odd: vec4<i32>, grays: vec2<u32>) -> Keys {
    return Keys(
        keys_of_four(vec4(even.x, odd.x, even.y, odd.y), grays.x),
        keys_of_four(vec4(even.z, odd.z, even.w, odd.w), grays.y));
}
