// texture: a left pixel keeps its disparity if min(|gx|, prefilter_cap), summed over its block, is at least a threshold.
// columns (u16, in rows like a map's), left_map (i16) -> textured (i16)
// One invocation: four words, eight pixels of a row.
// Border: columns are clamped into the image.
// With: common
// Reference: src/reference/filters/texture.rs

@group(0) @binding(2) var<storage, read> columns: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> left_map: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> textured: array<vec4<u32>>;

const RADIUS: i32 = i32(BLOCK / 2u);

// Vectors of eight columns that a block reaches beyond a pixel's own.
const AROUND: i32 = (RADIUS + 7) / 8;
const READ: u32 = u32(2 * AROUND + 1);

struct Sums {
    even: vec4<u32>,
    odd: vec4<u32>,
}

// Adds the value of the column `offset` columns right of the first pixel to the sums of all pixels whose block contains it.
fn enter(sums: ptr<function, Sums>, value: u32, offset: i32) {
    let even = abs(vec4(offset) - vec4(0, 2, 4, 6)) <= vec4(RADIUS);
    let odd = abs(vec4(offset) - vec4(1, 3, 5, 7)) <= vec4(RADIUS);
    (*sums).even += select(vec4(0u), vec4(value), even);
    (*sums).odd += select(vec4(0u), vec4(value), odd);
}

// Columns beyond a side have that side's value.
fn continued(values: vec4<u32>, x: vec4<i32>, left: u32, right: u32) -> vec4<u32> {
    return select(select(values, vec4(left), x < vec4(0)), vec4(right), x >= vec4(i32(frame.width)));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = frame.map_stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let row = id.y * stride;
    let last = frame.width - 1u;
    let last_words = columns[row + last / 8u];
    let last_word = select(select(last_words.x, last_words.y, (last & 2u) != 0u),
        select(last_words.z, last_words.w, (last & 2u) != 0u), (last & 4u) != 0u);
    let right = (last_word >> (16u * (last & 1u))) & 0xffffu;
    let left = columns[row].x & 0xffffu;
    var sums: Sums;
    // An array, so that the loop is unrolled: then every test of a distance is a constant.
    var vectors: array<vec4<u32>, READ>;
    for (var v = 0u; v < READ; v++) {
        let vector = i32(id.x + v) - AROUND;
        vectors[v] = columns[row + u32(clamp(vector, 0, i32(stride) - 1))];
        let x = vec4(8 * vector);
        let even = continued(vectors[v] & vec4(0xffffu), x + vec4(0, 2, 4, 6), left, right);
        let odd = continued(vectors[v] >> vec4(16u), x + vec4(1, 3, 5, 7), left, right);
        let offset = 8 * (i32(v) - AROUND);
        enter(&sums, even.x, offset);
        enter(&sums, odd.x, offset + 1);
        enter(&sums, even.y, offset + 2);
        enter(&sums, odd.y, offset + 3);
        enter(&sums, even.z, offset + 4);
        enter(&sums, odd.z, offset + 5);
        enter(&sums, even.w, offset + 6);
        enter(&sums, odd.w, offset + 7);
    }
    let words = left_map[row + id.x];
    let invalid = vec4(bitcast<u32>(INVALID) & 0xffffu);
    let low = select(invalid, words & vec4(0xffffu), sums.even >= vec4(frame.texture));
    let high = select(invalid, words >> vec4(16u), sums.odd >= vec4(frame.texture));
    textured[row + id.x] = low | (high << vec4(16u));
}
