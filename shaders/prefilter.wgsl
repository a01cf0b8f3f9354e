// prefilter: xsobel clamp(gx, -cap, cap) + cap; sobel min(floor(sqrt(gx^2 + gy^2)), 2 cap); none: the gray value.
// gray (u8, in a texture) -> plane (u8, sixteen pixels a vector, continued by the border so that the matching cost needs
//   no clamping)
//   left: byte j of a row is column j - r; right: byte j is column width - 1 + r - min_disparity - j, so that rising
//   disparities lie at rising addresses (r = block_radius).
// One invocation: one vector of a row of the plane. Border: rows are clamped into the image, columns are continued.
// Reference: src/reference/prefilter.rs

@group(0) @binding(2) var gray: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(3) var<storage, read_write> plane: array<vec4<u32>>;

// Twenty neighbouring pixels of a row.
alias Pixels = array<vec4<i32>, 5>;

fn gray_at(index: u32) -> vec4<u32> {
    return textureLoad(gray, vec2(index % TEXELS, index / TEXELS));
}

fn pixels(word: u32) -> vec4<i32> {
    return vec4<i32>(unpack(word));
}

// The pixels from column x on, which is -16 or more.
fn gray_pixels(x: i32, y: i32) -> Pixels {
    let byte = u32(x + 16);
    let at = u32(clamp(y, 0, i32(frame.height) - 1)) * frame.gray_stride + (byte >> 4u);
    let texels = array(gray_at(at), gray_at(at + 1u), gray_at(at + 2u));
    let a = from_word(texels[0], texels[1], byte >> 2u);
    let b = from_word(texels[1], texels[2], byte >> 2u);
    let words = from_byte(a, b.x, byte);
    return Pixels(pixels(words.x), pixels(words.y), pixels(words.z), pixels(words.w),
        pixels(from_byte(b, 0u, byte).x));
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

fn roots(n: vec4<i32>) -> vec4<i32> {
    let m = vec4<u32>(n);
    return vec4<i32>(vec4(integer_root(m.x), integer_root(m.y), integer_root(m.z), integer_root(m.w)));
}

// Four pixels: those in the middle of columns k .. k + 2 of the rows, k = 4 i .. 4 i + 3.
fn filtered(above: Pixels, here: Pixels, below: Pixels, i: u32) -> u32 {
    if PREFILTER == PREFILTER_NONE {
        return pack(vec4<u32>(vec4(here[i].yzw, here[i + 1u].x)));
    }
    let cap = vec4(i32(frame.prefilter_cap));
    let left = above[i] + 2 * here[i] + below[i];
    let next = above[i + 1u].xy + 2 * here[i + 1u].xy + below[i + 1u].xy;
    let gx = vec4(left.zw, next) - left;
    if PREFILTER == PREFILTER_XSOBEL {
        return pack(vec4<u32>(clamp(gx, -cap, cap) + cap));
    }
    let down = below[i] - above[i];
    let down_next = below[i + 1u].xy - above[i + 1u].xy;
    let gy = down + 2 * vec4(down.yzw, down_next.x) + vec4(down.zw, down_next);
    return pack(vec4<u32>(min(roots(gx * gx + gy * gy), 2 * cap)));
}

fn reversed(words: vec4<u32>) -> vec4<u32> {
    let w = words.wzyx;
    return vec4(pack(unpack(w.x).wzyx), pack(unpack(w.y).wzyx), pack(unpack(w.z).wzyx), pack(unpack(w.w).wzyx));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let mirrored = pass_.side == 1u;
    let stride = select(frame.left_stride, frame.right_stride, mirrored) / 4u;
    if id.x >= stride || id.y >= frame.height {
        return;
    }
    let j = 16 * i32(id.x);
    let r = i32(frame.block_radius);
    let last = i32(frame.width) - 1;
    // The lowest of the sixteen columns. At least one of them must lie in the image.
    let x = clamp(select(j - r, last + r - frame.min_disparity - j - 15, mirrored), -15, last);
    let y = i32(id.y);
    let above = gray_pixels(x - 1, y - 1);
    let here = gray_pixels(x - 1, y);
    let below = gray_pixels(x - 1, y + 1);
    var words = vec4(filtered(above, here, below, 0u), filtered(above, here, below, 1u),
        filtered(above, here, below, 2u), filtered(above, here, below, 3u));
    words = select_bits(words, byte_at(words, -x), low_bytes(-x));
    words = select_bits(byte_at(words, last - x), words, low_bytes(last - x));
    plane[id.y * stride + id.x] = select(words, reversed(words), vec4(mirrored));
}
