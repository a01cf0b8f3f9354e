// prefilter: xsobel clamp(gx, -cap, cap) + cap; sobel min(floor(sqrt(gx^2 + gy^2)), 2 cap); none: the gray value.
// gray (u8) -> plane (u8, four pixels a word, continued by the border so that the matching cost needs no clamping)
//   left: byte j of a row is column j - r; right: byte j is column width - 1 + r - min_disparity - j, so that rising
//   disparities lie at rising addresses (r = block_radius).
// One invocation: one word of a row of the plane. Border: coordinates are clamped into the image.
// Reference: src/reference/prefilter.rs

@group(0) @binding(2) var<storage, read> gray: array<u32>;
@group(0) @binding(3) var<storage, read_write> plane: array<u32>;

fn gray_at(x: i32, y: i32) -> i32 {
    let cx = u32(clamp(x, 0, i32(frame.width) - 1));
    let cy = u32(clamp(y, 0, i32(frame.height) - 1));
    return i32(extractBits(gray[cy * frame.gray_stride + (cx >> 2u)], (cx & 3u) * 8u, 8u));
}

// floor(sqrt(n)) for n < 2^24: the float root is off by at most one, the integers decide.
fn integer_root(n: u32) -> u32 {
    var root = u32(sqrt(f32(n)));
    if root * root > n {
        root -= 1u;
    }
    if (root + 1u) * (root + 1u) <= n {
        root += 1u;
    }
    return root;
}

fn filtered(unclamped: i32, y: i32) -> u32 {
    let x = clamp(unclamped, 0, i32(frame.width) - 1);
    let cap = i32(frame.prefilter_cap);
    if PREFILTER == PREFILTER_NONE {
        return u32(gray_at(x, y));
    }
    let left = vec3(gray_at(x - 1, y - 1), gray_at(x - 1, y), gray_at(x - 1, y + 1));
    let right = vec3(gray_at(x + 1, y - 1), gray_at(x + 1, y), gray_at(x + 1, y + 1));
    let gx = right.x - left.x + 2 * (right.y - left.y) + right.z - left.z;
    if PREFILTER == PREFILTER_XSOBEL {
        return u32(clamp(gx, -cap, cap) + cap);
    }
    let gy = left.z - left.x + 2 * (gray_at(x, y + 1) - gray_at(x, y - 1)) + right.z - right.x;
    return min(integer_root(u32(gx * gx + gy * gy)), u32(2 * cap));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = select(frame.left_stride, frame.right_stride, pass_.side == 1u);
    if id.x >= stride || id.y >= frame.height {
        return;
    }
    let j = i32(4u * id.x);
    let r = i32(frame.block_radius);
    let x = select(j - r, i32(frame.width) - 1 + r - frame.min_disparity - j, pass_.side == 1u);
    let step = select(1, -1, pass_.side == 1u);
    let y = i32(id.y);
    plane[id.y * stride + id.x] = pack(vec4(
        filtered(x, y), filtered(x + step, y), filtered(x + 2 * step, y), filtered(x + 3 * step, y)));
}
