// weighted_median_parallel: weighted_median with the schedule per-subgroup: few registers rather than few loads.
// map (i16, in a texture), gray (u8, of the left image, in a texture) -> filtered (i16)
// One invocation: a word, two pixels of a row.
// Border: pixels outside the image and invalid ones have no weight; an invalid pixel stays invalid.
// With: weighted_keys, gray_weight, map_octet, common
// Reference: src/reference/filters/weighted_median.rs

@group(0) @binding(3) var<storage, read_write> filtered: array<u32>;
@group(0) @binding(4) var gray: texture_storage_2d<rgba32uint, read>;

fn word_of(words: vec4<u32>, k: u32) -> u32 {
    let two = select(words.xy, words.zw, vec2((k & 2u) != 0u));
    return select(two.x, two.y, (k & 1u) != 0u);
}

// Two pixels of a row from an even column on: each a value, above invalid, which is 0, above its gray value; 0 outside the image. A row
// of the gray image begins with sixteen columns before it.
fn two_at(column: u32, row: u32) -> vec2<u32> {
    // Numbers below zero are larger than all others.
    let inside = (vec2(column, column + 1u) < vec2(frame.width)) & vec2(row < frame.height);
    let x = select(0u, column, inside.x);
    let y = select(0u, row, inside.x);
    let values = word_of(map_at(y * (frame.map_stride / 4u) + x / 8u), x / 2u) ^ NOTHING;
    let index = y * frame.gray_stride + x / 16u + 1u;
    let grays = word_of(textureLoad(gray, vec2(index % TEXELS, index / TEXELS)), x / 4u) >> ((x & 2u) * 8u);
    let both = vec2((values << 16u) | (grays & 255u), (values & 0xffff0000u) | ((grays >> 8u) & 255u));
    return select(vec2(0u), both, inside);
}

// The weighted median of what is seen around a pixel.
fn median_of(seen: array<u32, 25>) -> u32 {
    var keys = seen;
    let middle_one = keys[12];
    let here = middle_one & 255u;
    for (var n = 0u; n < 25u; n++) {
        let there = keys[n] & 255u;
        let difference = max(here, there) - min(here, there);
        let value = keys[n] & 0xffff0000u;
        keys[n] = value | select(weight(difference), 0u, value == 0u);
    }
    sort(&keys);
    return select(0u, middle(&keys), middle_one > 0xffffu);
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.map_stride || id.y >= dispatch.rows {
        return;
    }
    let y = dispatch.first_row + id.y;
    var low = array<u32, 25>();
    var high = array<u32, 25>();
    for (var n = 0u; n < 25u; n++) {
        let column = 2u * id.x + n % 5u * SPACING - 2u * SPACING;
        let row = y + n / 5u * SPACING - 2u * SPACING;
        // One word holds both, or two words one each.
        if (n % 5u * SPACING) % 2u == 0u {
            let both = two_at(column, row);
            low[n] = both.x;
            high[n] = both.y;
        } else {
            low[n] = two_at(column - 1u, row).y;
            high[n] = two_at(column + 1u, row).x;
        }
    }
    filtered[id.y * frame.map_stride + id.x] = NOTHING ^ (median_of(low) | (median_of(high) << 16u));
}
