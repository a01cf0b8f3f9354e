// fill_between: an invalid pixel takes the smaller of the two nearest values of its row or column, or the only one.
// map (i16, in a texture), nearest (i16, of fill_rows or fill_lines), seen (a bit a pixel) -> filled (i16)
// One invocation: four words, eight pixels of a row.
// With: map_octet, common
// Reference: src/reference/filters/fill.rs

struct Own {
    occlusions: u32,    // 1: occlusions are not filled like mismatches
}

@group(0) @binding(3) var<storage, read> nearest: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> seen: array<u32>;
@group(0) @binding(5) var<storage, read_write> filled: array<vec4<u32>>;

fn farther(a: vec4<i32>, b: vec4<i32>) -> vec4<i32> {
    return select(min(a, b), max(a, b), min(a, b) == vec4(INVALID));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let row = dispatch.first_row + id.y;
    let p = octet(row, id.x);
    var wanted = mask(p.even == vec4(INVALID), p.odd == vec4(INVALID));
    if dispatch.own.occlusions == 1u {
        wanted &= ~(seen[row * stride + (id.x >> 2u)] >> (8u * (id.x & 3u)));
    }
    var even = p.even;
    var odd = p.odd;
    if wanted != 0u {
        let at = 2u * (id.y * (stride + 1u) + id.x);
        let a = nearest[at];
        let b = nearest[at + 1u];
        let e = farther(
            bitcast<vec4<i32>>(a << vec4(16u)) >> vec4(16u), bitcast<vec4<i32>>(b << vec4(16u)) >> vec4(16u));
        let o = farther(bitcast<vec4<i32>>(a) >> vec4(16u), bitcast<vec4<i32>>(b) >> vec4(16u));
        even = select(even, e, (vec4(wanted) & vec4(1u, 4u, 16u, 64u)) != vec4(0u));
        odd = select(odd, o, (vec4(wanted) & vec4(2u, 8u, 32u, 128u)) != vec4(0u));
    }
    filled[id.y * stride + id.x] = pack_octet(even, odd);
}
