// fill_rays_weighted: an invalid pixel takes the weighted median of the nearest values on eight rays: a value weighs 1 and what the
//   difference of its pixel's gray from the pixel's own does.
// map (i16, in a texture), gray (u8, of the left image, in a texture), nearest (keys, u32, of fill_rows_gray and fill_lines_gray)
//   -> filled (i16)
// One invocation: four words, eight pixels of a row.
// With: gray_weight, line_slots, gray_octet, map_octet, common
// Reference: src/reference/filters/fill.rs

@group(0) @binding(3) var<storage, read_write> filled: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> along: array<u32>;
@group(0) @binding(6) var<storage, read> falling: array<u32>;
@group(0) @binding(7) var<storage, read> upright: array<u32>;
@group(0) @binding(8) var<storage, read> rising: array<u32>;

// The key of a pixel on a line that goes dx columns to the right from row to row, on its way down; on its way up, 8 on.
fn place(x: i32, y: i32, dx: i32) -> u32 {
    let line = x - dx * y;
    return 16u * slot_of(line >> 3u, y, dx) + u32(line & 7);
}

// What four keys weigh.
fn weights(keys: vec4<u32>, own: u32) -> vec4<u32> {
    let there = keys & vec4(255u);
    let differences = max(there, vec4(own)) - min(there, vec4(own));
    let all = vec4(
        weight(differences.x), weight(differences.y), weight(differences.z), weight(differences.w));
    return select(all + vec4(1u), vec4(0u), keys == vec4(0u));
}

fn sum(v: vec4<u32>) -> u32 {
    return v.x + v.y + v.z + v.w;
}

// The smallest value for which those that are not larger have half of the weight; 0, which is invalid, if there is none.
fn weighted_median(first: vec4<u32>, second: vec4<u32>, own: u32) -> u32 {
    let a = first >> vec4(16u);
    let b = second >> vec4(16u);
    let of_a = weights(first, own);
    let of_b = weights(second, own);
    let total = sum(of_a + of_b);
    var found = 0xffffu;
    for (var i = 0u; i < 8u; i++) {
        let value = select(b[i & 3u], a[i & 3u], i < 4u);
        let larger = vec4(value);
        let reached = sum(select(of_a, vec4(0u), a > larger) + select(of_b, vec4(0u), b > larger));
        found = select(found, min(found, value), 2u * reached >= total);
    }
    return found;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let row = dispatch.first_row + id.y;
    let p = octet(row, id.x);
    let grays = gray_words(row, id.x + 2u);
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
            let first = vec4(along[r], upright[r], falling[f], rising[g]);
            let second = vec4(along[r + 8u], upright[r + 8u], falling[f + 8u], rising[g + 8u]);
            let own = (select(grays.x, grays.y, j > 3u) >> (8u * (j & 3u))) & 255u;
            let half = 16u * (j & 1u);
            let bits = (weighted_median(first, second, own) ^ 0x8000u) << half;
            let kept = 0xffff0000u >> half;
            words = select(words, (words & vec4(kept)) | vec4(bits), vec4(j >> 1u) == vec4(0u, 1u, 2u, 3u));
        }
    }
    filled[id.y * stride + id.x] = words;
}
