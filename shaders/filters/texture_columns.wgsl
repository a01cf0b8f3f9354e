// texture_columns: of the `block` pixels above each other around a pixel, the sum of min(|gx|, prefilter_cap).
// gray (u8, in a texture) -> columns (u16, in rows like a map's)
// One invocation: sixteen columns of SEGMENT rows, downwards; a row enters the sums as another leaves them.
// Border: rows are clamped into the image, before gx is taken and within it; the gray image is continued. With OPENCV_RULES
//   gx is that of OpenCV's StereoBM.
// With: common
// Reference: src/reference/filters/texture.rs

@group(0) @binding(2) var gray: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(3) var<storage, read_write> columns: array<vec4<u32>>;

// Sixteen columns, two 16-bit numbers a word: the even ones and the odd ones.
struct Columns {
    even: vec4<u32>,
    odd: vec4<u32>,
}

// Eighteen: the odd column before the sixteen in the high half, the even one after them in the low half.
struct Smoothed {
    even: vec4<u32>,
    odd: vec4<u32>,
    before: u32,
    after: u32,
}

const BYTES: u32 = 0xff00ffu;

fn add_row(sum: ptr<function, Smoothed>, group: u32, y: i32, weight: u32) {
    let at = u32(clamp(y, 0, i32(frame.height) - 1)) * frame.gray_stride + group;
    let before = textureLoad(gray, vec2(at % TEXELS, at / TEXELS)).w;
    let here = textureLoad(gray, vec2((at + 1u) % TEXELS, (at + 1u) / TEXELS));
    let after = textureLoad(gray, vec2((at + 2u) % TEXELS, (at + 2u) / TEXELS)).x;
    (*sum).even += weight * (here & vec4(BYTES));
    (*sum).odd += weight * ((here >> vec4(8u)) & vec4(BYTES));
    (*sum).before += weight * ((before >> 8u) & BYTES);
    (*sum).after += weight * (after & BYTES);
}

fn clipped(a: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
    let low = abs(vec4<i32>(a & vec4(0xffffu)) - vec4<i32>(b & vec4(0xffffu)));
    let high = abs(vec4<i32>(a >> vec4(16u)) - vec4<i32>(b >> vec4(16u)));
    let cap = vec4(frame.prefilter_cap);
    return min(vec4<u32>(low), cap) | (min(vec4<u32>(high), cap) << vec4(16u));
}

// Halves of words, of the columns `low` and `high`, that are neither the first nor the last column.
fn between_borders(low: vec4<u32>, high: vec4<u32>) -> vec4<u32> {
    let last = vec4(frame.width - 1u);
    return select(vec4(0u), vec4(0xffffu), (low != vec4(0u)) & (low != last))
        | select(vec4(0u), vec4(0xffff0000u), (high != vec4(0u)) & (high != last));
}

// min(|gx|, prefilter_cap) of the row nearest to y.
fn derivatives(group: u32, y: i32) -> Columns {
    let last = i32(frame.height) - 1;
    let row = clamp(y, 0, last);
    var s: Smoothed;
    if OPENCV_RULES == 1u {
        if row == last && (last & 1) == 0 {
            return Columns();
        }
        add_row(&s, group, abs(row - 1), 1u);
        add_row(&s, group, row, 2u);
        add_row(&s, group, last - abs(last - row - 1), 1u);
        let first = vec4(16u * group) + vec4(0u, 4u, 8u, 12u);
        let kept = Columns(between_borders(first, first + vec4(2u)), between_borders(first + vec4(1u), first + vec4(3u)));
        let all = clipped_columns(s);
        return Columns(all.even & kept.even, all.odd & kept.odd);
    }
    add_row(&s, group, row - 1, 1u);
    add_row(&s, group, row, 2u);
    add_row(&s, group, row + 1, 1u);
    return clipped_columns(s);
}

fn clipped_columns(s: Smoothed) -> Columns {
    let before = (s.odd << vec4(16u)) | (vec4(s.before, s.odd.xyz) >> vec4(16u));
    let after = (s.even >> vec4(16u)) | (vec4(s.even.yzw, s.after) << vec4(16u));
    return Columns(clipped(s.odd, before), clipped(after, s.even));
}

// Eight columns in their order.
fn ordered(even: vec2<u32>, odd: vec2<u32>) -> vec4<u32> {
    let first = (even & vec2(0xffffu)) | (odd << vec2(16u));
    let second = (even >> vec2(16u)) | (odd & vec2(0xffff0000u));
    return vec4(first.x, second.x, first.y, second.y);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    let first = i32(dispatch.first_row + id.y * SEGMENT);
    let behind = i32(dispatch.first_row + dispatch.rows);
    if 2u * id.x >= stride || first >= behind {
        return;
    }
    let r = i32(frame.block_radius);
    var sum: Columns;
    for (var y = first - r; y < first + r; y++) {
        let row = derivatives(id.x, y);
        sum.even += row.even;
        sum.odd += row.odd;
    }
    let end = min(first + i32(SEGMENT), behind);
    for (var y = first; y < end; y++) {
        let entering = derivatives(id.x, y + r);
        sum.even += entering.even;
        sum.odd += entering.odd;
        let at = (u32(y) - dispatch.first_row) * stride + 2u * id.x;
        columns[at] = ordered(sum.even.xy, sum.odd.xy);
        if 2u * id.x + 1u < stride {
            columns[at + 1u] = ordered(sum.even.zw, sum.odd.zw);
        }
        let leaving = derivatives(id.x, y - r);
        sum.even -= leaving.even;
        sum.odd -= leaving.odd;
    }
}
