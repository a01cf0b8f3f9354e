// prefilter: xsobel clamp(gx, -cap, cap) + cap; sobel min(floor(sqrt(gx^2 + gy^2)), 2 cap); none: the gray value.
// gray (u8) -> plane (u8, four pixels a word, continued by the border so that the matching cost needs no clamping)
//   left: byte j of a row is column j - r; right: byte j is column width - 1 + r - min_disparity - j, so that rising
//   disparities lie at rising addresses (r = block_radius).
// One invocation: one word of a row of the plane. Border: coordinates are clamped into the image.
// Reference: src/reference/prefilter.rs

@group(0) @binding(2) var<storage, read> gray: array<u32>;
@group(0) @binding(3) var<storage, read_write> plane: array<u32>;

// Twelve neighbouring gray pixels of a row, from column `base` on, which is a multiple of four.
fn gray_words(base: i32, y: i32) -> vec3<u32> {
    let row = u32(clamp(y, 0, i32(frame.height) - 1)) * frame.gray_stride;
    let last = frame.gray_stride - 1u;
    let word = u32(base) >> 2u;
    return vec3(gray[row + word], gray[row + min(word + 1u, last)], gray[row + min(word + 2u, last)]);
}

// The pixel at column base + offset.
fn pick(words: vec3<u32>, offset: u32) -> i32 {
    let word = select(select(words.z, words.y, offset < 8u), words.x, offset < 4u);
    return i32((word >> ((offset & 3u) * 8u)) & 255u);
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

fn filtered(x: i32, base: i32, above: vec3<u32>, here: vec3<u32>, below: vec3<u32>) -> u32 {
    let last = i32(frame.width) - 1;
    let centre = clamp(x, 0, last);
    let cap = i32(frame.prefilter_cap);
    let c = u32(centre - base);
    if PREFILTER == PREFILTER_NONE {
        return u32(pick(here, c));
    }
    let l = u32(max(centre - 1, 0) - base);
    let r = u32(min(centre + 1, last) - base);
    let left = vec3(pick(above, l), pick(here, l), pick(below, l));
    let right = vec3(pick(above, r), pick(here, r), pick(below, r));
    let gx = right.x - left.x + 2 * (right.y - left.y) + right.z - left.z;
    if PREFILTER == PREFILTER_XSOBEL {
        return u32(clamp(gx, -cap, cap) + cap);
    }
    let gy = left.z - left.x + 2 * (pick(below, c) - pick(above, c)) + right.z - right.x;
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
    // The four pixels and their neighbours span six columns at most: they lie in three words.
    let leftmost = clamp(min(x, x + 3 * step), 0, i32(frame.width) - 1);
    let base = max(leftmost - 1, 0) & ~3;
    let above = gray_words(base, y - 1);
    let here = gray_words(base, y);
    let below = gray_words(base, y + 1);
    plane[id.y * stride + id.x] = pack(vec4(
        filtered(x, base, above, here, below), filtered(x + step, base, above, here, below),
        filtered(x + 2 * step, base, above, here, below), filtered(x + 3 * step, base, above, here, below)));
}
