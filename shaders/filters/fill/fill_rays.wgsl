// fill_rays: an invalid pixel takes the median of the nearest values on eight rays, the lower one of an even number; where
//   dispatch.own.occlusions is 1 and no right pixel points to it, the second lowest.
// map (i16, in a texture), nearest (i16, of fill_rows and fill_lines), seen (a bit a pixel) -> filled (i16)
// One invocation: four words, eight pixels of a row.
// With: line_slots, map_octet, common
// Reference: src/reference/filters/fill.rs

struct Own {
    occlusions: u32,    // 1: occlusions are not filled like mismatches
}

@group(0) @binding(3) var<storage, read> along: array<u32>;
@group(0) @binding(4) var<storage, read> falling: array<u32>;
@group(0) @binding(5) var<storage, read> upright: array<u32>;
@group(0) @binding(6) var<storage, read> rising: array<u32>;
@group(0) @binding(7) var<storage, read> seen: array<u32>;
@group(0) @binding(8) var<storage, read_write> filled: array<vec4<u32>>;

// The word of a pixel on a line that goes dx columns to the right from row to row, on its way down; on its way up, 4 on.
fn place(x: i32, y: i32, dx: i32) -> u32 {
    let line = x - dx * y;
    return 8u * slot_of(line >> 3u, y, dx) + u32((line & 7) >> 1u);
}

// The value of a rank, from 0, of those that are valid among eight.
fn ranked(a: vec4<i32>, b: vec4<i32>, second: bool) -> i32 {
    let valid = countOneBits(mask(a != vec4(INVALID), b != vec4(INVALID)));
    let rank = select((valid - 1u) / 2u, min(valid - 1u, 1u), second) + 8u - valid;
    // At most `rank` values are lower, and more than `rank` are lower or equal.
    var found = INVALID;
    for (var i = 0u; i < 8u; i++) {
        let value = select(b[i & 3u], a[i & 3u], i < 4u);
        let lower = countOneBits(mask(a < vec4(value), b < vec4(value)));
        let equal = countOneBits(mask(a == vec4(value), b == vec4(value)));
        found = select(found, value, lower <= rank && rank < lower + equal);
    }
    return select(found, INVALID, valid == 0u);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let row = dispatch.first_row + id.y;
    let p = octet(row, id.x);
    let marks = seen[row * stride + (id.x >> 2u)] >> (8u * (id.x & 3u));
    var words = pack_octet(p.even, p.odd);
    var rest = mask(p.even == vec4(INVALID), p.odd == vec4(INVALID));
    let y = i32(row);
    while rest != 0u {
        let j = firstTrailingBit(rest);
        rest &= rest - 1u;
        let x = i32(8u * id.x + j);
        if x < i32(frame.width) {
            let r = place(x, y, 0);
            let f = place(x, y, 1);
            let g = place(x, y, -1);
            let half = j & 1u;
            let first = vec4(map_value(along[r], half), map_value(upright[r], half),
                map_value(falling[f], u32(x - y)), map_value(rising[g], u32(x + y)));
            let second = vec4(map_value(along[r + 4u], half), map_value(upright[r + 4u], half),
                map_value(falling[f + 4u], u32(x - y)), map_value(rising[g + 4u], u32(x + y)));
            let value = ranked(first, second, dispatch.own.occlusions == 1u && ((marks >> j) & 1u) == 0u);
            let bits = (bitcast<u32>(value) & 0xffffu) << (16u * half);
            let kept = 0xffff0000u >> (16u * half);
            words = select(words, (words & vec4(kept)) | vec4(bits), vec4(j >> 1u) == vec4(0u, 1u, 2u, 3u));
        }
    }
    filled[id.y * stride + id.x] = words;
}
