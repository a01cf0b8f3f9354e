// Appended to the median filters: a result that points outside the right image is invalid.

fn invalidate_outside(x: vec4<i32>, values: vec4<i32>) -> vec4<i32> {
    let seen = x - ((values + vec4(8)) >> vec4(4u));
    return select(vec4(INVALID), values, (seen >= vec4(0)) & (seen < vec4(i32(frame.width))));
}
