// features: the bytes of each pixel that the matching cost compares: census strings, derivatives, bounds between pixels,
//   values less the mean of the block.
// image (u8 or u16, in a texture), sums (u32, [y][x], of the blocks) -> planes (u8, four pixels a word, from plane
//   first_plane on; continued by the border)
//   Byte j of a row is column j - lead, or if it is mirrored column lead - j.
// One invocation: four pixels of a row in all planes. Border: rows are clamped into the image, columns are continued.
// Reference: src/reference/features.rs

@group(0) @binding(3) var<storage, read> sums: array<u32>;
@group(0) @binding(4) var<storage, read_write> planes: array<u32>;

// Words of all planes that an image gives.
alias Words = array<u32, IMAGE_PLANES>;

// Four census strings of 64 bits, as they grow.
struct Strings {
    low: vec4<u32>,
    high: vec4<u32>,
}

fn push(strings: Strings, bits: vec4<u32>, count: u32) -> Strings {
    return Strings((strings.low << vec4(count)) | bits,
        (strings.high << vec4(count)) | (strings.low >> vec4(32u - count)));
}

// The pixels 4 columns before four pixels, 3 before them, and so on to 4 after.
fn neighbours(row: Pixels) -> array<vec4<i32>, 9> {
    let a = row[0];
    let b = row[1];
    let c = row[2];
    return array(a, vec4(a.yzw, b.x), vec4(a.zw, b.xy), vec4(a.w, b.xyz), b,
        vec4(b.yzw, c.x), vec4(b.zw, c.xy), vec4(b.w, c.xyz), c);
}

// Nine bits, the first neighbour's highest: which are less than what they are compared with.
fn nine_bits(of_row: array<vec4<i32>, 9>, than: array<vec4<i32>, 9>) -> vec4<u32> {
    var row = of_row;
    var other = than;
    var bits = vec4(0u);
    for (var k = 0u; k < 9u; k++) {
        bits |= select(vec4(0u), vec4(256u >> k), row[k] < other[k]);
    }
    return bits;
}

fn all(v: vec4<i32>) -> array<vec4<i32>, 9> {
    return array(v, v, v, v, v, v, v, v, v);
}

fn opposite(row: array<vec4<i32>, 9>) -> array<vec4<i32>, 9> {
    return array(row[8], row[7], row[6], row[5], row[4], row[3], row[2], row[1], row[0]);
}

// The census strings of the four pixels from column x on.
fn census(x: i32, y: i32) -> Strings {
    var strings: Strings;
    let here = neighbours(pixels_from(x - 4, y));
    if CENSUS == CENSUS_SYMMETRIC {
        for (var dy = -3; dy < 0; dy++) {
            let row = neighbours(pixels_from(x - 4, y + dy));
            let other = neighbours(pixels_from(x - 4, y - dy));
            strings = push(strings, nine_bits(row, opposite(other)), 9u);
        }
        return push(strings, nine_bits(here, opposite(here)) >> vec4(5u), 4u);
    }
    let centre = all(here[4]);
    let side = CENSUS_COLUMNS / 2u;
    for (var dy = -i32(CENSUS_ROWS / 2u); dy <= i32(CENSUS_ROWS / 2u); dy++) {
        let row = nine_bits(neighbours(pixels_from(x - 4, y + dy)), centre) >> vec4(4u - side);
        if dy == 0 {
            let halves = ((row >> vec4(side + 1u)) << vec4(side)) | (row & vec4((1u << side) - 1u));
            strings = push(strings, halves & vec4((1u << (2u * side)) - 1u), 2u * side);
        } else {
            strings = push(strings, row & vec4((1u << CENSUS_COLUMNS) - 1u), CENSUS_COLUMNS);
        }
    }
    return strings;
}

fn byte_of(strings: Strings, plane: u32) -> u32 {
    let word = select(strings.low, strings.high, vec4(plane >= 4u));
    return pack((word >> vec4(8u * (plane & 3u))) & vec4(255u));
}

fn clipped(gradient: vec4<i32>) -> u32 {
    let cap = vec4(i32(frame.prefilter_cap));
    return pack(vec4<u32>(clamp(gradient, -cap, cap) + cap));
}

// The value less the mean of the block, rounded, halves upwards.
fn excess(values: vec4<i32>, x: i32, y: i32) -> u32 {
    let columns = vec4<u32>(clamp(vec4(x) + vec4(0, 1, 2, 3), vec4(0), vec4(i32(frame.width) - 1)));
    let at = vec4(u32(y) * frame.width) + columns;
    let sum = vec4<i32>(vec4(sums[at.x], sums[at.y], sums[at.z], sums[at.w]));
    let n = i32(BLOCK * BLOCK);
    let half = n * select(1, 257, pass_.deep == 1u);
    let rounded = mean_in_levels(2 * (n * values - sum) + vec4(half), 2 * n);
    return pack(vec4<u32>(clamp(rounded, vec4(-127), vec4(127)) + vec4(127)));
}

// The bytes of the four pixels from column x on, which is -3 or more.
fn features(x: i32, y: i32) -> Words {
    var words: Words;
    if CENSUS_PLANES > 0u {
        let strings = census(x, y);
        for (var p = 0u; p < IMAGE_PLANES; p++) {
            words[p] = byte_of(strings, p);
        }
    }
    let above = pixels_from(x - 1, y - 1);
    let here = pixels_from(x - 1, y);
    let below = pixels_from(x - 1, y + 1);
    let values = vec4(here[0].yzw, here[1].x);
    if COST == COST_SAD_XY || COST == COST_CENSUS_SOBEL {
        words[min(CENSUS_PLANES, IMAGE_PLANES - 1u)] = clipped(sobel_x(above, here, below, 0u));
        words[IMAGE_PLANES - 1u] = clipped(sobel_y(above, below, 0u));
    }
    if COST == COST_AD_CENSUS {
        words[IMAGE_PLANES - 1u] = pack(vec4<u32>(in_levels(values)));
    }
    if COST == COST_ZSAD {
        words[0] = excess(values, x, y);
    }
    if COST == COST_BT {
        let v = vec4<u32>(in_levels(values));
        let before = (v + vec4<u32>(in_levels(here[0]))) >> vec4(1u);
        let after = (v + vec4<u32>(in_levels(vec4(here[0].zw, here[1].xy)))) >> vec4(1u);
        words[0] = pack(v);
        words[1u % IMAGE_PLANES] = pack(min(v, min(before, after)));
        words[2u % IMAGE_PLANES] = pack(max(v, max(before, after)));
    }
    return words;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= pass_.stride || id.y >= frame.height {
        return;
    }
    let mirrored = pass_.mirrored == 1u;
    let j = 4 * i32(id.x);
    let last = i32(frame.width) - 1;
    // The lowest of the four columns. At least one of them must lie in the image.
    let x = clamp(select(j - pass_.lead, pass_.lead - j - 3, mirrored), -3, last);
    var words = features(x, i32(id.y));
    // Columns beyond the border take the byte of the one next to them.
    let order = select(vec4(0, 1, 2, 3), vec4(3, 2, 1, 0), vec4(mirrored));
    let shifts = 8u * vec4<u32>(clamp(order, vec4(max(-x, 0)), vec4(min(last - x, 3))));
    for (var p = 0u; p < IMAGE_PLANES; p++) {
        let row = (pass_.first_plane + p) * frame.height + id.y;
        planes[row * pass_.stride + id.x] = pack((vec4(words[p]) >> shifts) & vec4(255u));
    }
}
