// descriptors: the bytes of each pixel that the matching cost compares: census strings, derivatives, bounds between pixels,
//   values less the mean of the block.
// image (u8 or u16, in a texture), sums (u32, [y][x], of the blocks) -> planes (u8, sixteen pixels a vector, from plane
//   first_plane on; continued by the border)
//   Byte j of a row is column j - lead, or if it is mirrored column lead - j.
// One invocation: one vector, sixteen pixels of a row, in all planes. Border: rows are clamped into the image, columns
//   are continued.
// With: gray_pixels, plane_layout, bytes, common
// Reference: src/reference/cost/descriptors.rs

@group(0) @binding(3) var<storage, read> sums: array<u32>;
@group(0) @binding(4) var<storage, read_write> planes: array<vec4<u32>>;

const TOP_BITS: vec4<u32> = vec4(0x80808080u);

// Sixteen pixels in all planes that an image gives.
alias Words = array<vec4<u32>, IMAGE_PLANES>;

// Twenty-four pixels of a row, from four columns before sixteen pixels on: sixteen from the first, the fifth and the ninth
// of them on.
struct Row {
    before: vec4<u32>,
    here: vec4<u32>,
    after: vec4<u32>,
}

fn row_at(x: i32, y: i32) -> Row {
    let first = u32(x + 12);
    let start = u32(clamp(y, 0, i32(frame.height) - 1)) * frame.gray_stride;
    let at = start + u32((x + 12) >> 4u);
    let texels = array(first_texel(start, x + 12), image_at(at + 1u), image_at(at + 2u));
    let a = from_word(texels[0], texels[1], first >> 2u);
    let b = from_word(texels[1], texels[2], first >> 2u);
    let c = from_byte(a, b.x, first);
    let d = from_byte(b, 0u, first);
    return Row(c, vec4(c.yzw, d.x), vec4(c.zw, d.xy));
}

// The pixels dx columns to the right of the sixteen, -4 to 4.
fn moved(row: Row, dx: i32) -> vec4<u32> {
    if dx == -4 {
        return row.before;
    }
    if dx == 0 {
        return row.here;
    }
    if dx == 4 {
        return row.after;
    }
    let shift = vec4((u32(dx) & 3u) * 8u);
    if dx < 0 {
        return (row.before >> shift) | ((row.here << vec4(1u)) << (vec4(31u) - shift));
    }
    return (row.here >> shift) | ((row.after << vec4(1u)) << (vec4(31u) - shift));
}

// The top bit of each byte: whether it is less than the other one.
fn less(a: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
    let low_bits = (a | TOP_BITS) - (b & ~TOP_BITS); // the top bit: no less in the lower seven
    return ~((a & ~b) | (~(a ^ b) & low_bits)) & TOP_BITS;
}

// Eight neighbours of a row, and the ninth: bits of the bytes.
struct Bits {
    eight: vec4<u32>,
    ninth: vec4<u32>, // in bit 0
}

fn row_bits(row: Row, other: Row, symmetric: bool) -> Bits {
    let towards = select(0, 1, symmetric);
    return Bits(
        (less(moved(row, -4), moved(other, 4 * towards)) >> vec4(7u))
            | (less(moved(row, -3), moved(other, 3 * towards)) >> vec4(6u))
            | (less(moved(row, -2), moved(other, 2 * towards)) >> vec4(5u))
            | (less(moved(row, -1), moved(other, towards)) >> vec4(4u))
            | (less(moved(row, 0), moved(other, 0)) >> vec4(3u))
            | (less(moved(row, 1), moved(other, -towards)) >> vec4(2u))
            | (less(moved(row, 2), moved(other, -2 * towards)) >> vec4(1u))
            | less(moved(row, 3), moved(other, -3 * towards)),
        less(moved(row, 4), moved(other, -4 * towards)) >> vec4(7u));
}

// The same of an image with values of 16 bits, four pixels at a time: bits 0 to 8.
fn deep_bits(x: i32, y: i32, other_y: i32, symmetric: bool) -> vec4<u32> {
    let row = deep_neighbours(x, y);
    let other = deep_neighbours(x, other_y);
    var bits = vec4(0u);
    for (var k = 0u; k < 9u; k++) {
        bits |= select(vec4(0u), vec4(1u << k), row[k] < select(other[4], other[8u - k], symmetric));
    }
    return bits;
}

fn deep_neighbours(x: i32, y: i32) -> array<vec4<i32>, 9> {
    let row = pixels_from(x - 4, y);
    let a = row[0];
    let b = row[1];
    let c = row[2];
    return array(a, vec4(a.yzw, b.x), vec4(a.zw, b.xy), vec4(a.w, b.xyz), b,
        vec4(b.yzw, c.x), vec4(b.zw, c.xy), vec4(b.w, c.xyz), c);
}

// The bits of the row dy rows below that of sixteen pixels, compared with the centre or the opposite row.
fn census_row(x: i32, y: i32, dy: i32) -> Bits {
    let symmetric = CENSUS == CENSUS_SYMMETRIC;
    let other_y = select(y, y - dy, symmetric);
    if DEEP == 1u {
        let a = deep_bits(x, y + dy, other_y, symmetric);
        let b = deep_bits(x + 4, y + dy, other_y, symmetric);
        let c = deep_bits(x + 8, y + dy, other_y, symmetric);
        let d = deep_bits(x + 12, y + dy, other_y, symmetric);
        let low = vec4(255u);
        let high = vec4(8u);
        return Bits(vec4(pack(a & low), pack(b & low), pack(c & low), pack(d & low)),
            vec4(pack(a >> high), pack(b >> high), pack(c >> high), pack(d >> high)));
    }
    return row_bits(row_at(x, y + dy), row_at(x, other_y), symmetric);
}

// The census strings of sixteen pixels: a plane a row, and one for the ninth column.
fn census(x: i32, y: i32) -> Words {
    let side = CENSUS_COLUMNS / 2u;
    let columns = (((1u << CENSUS_COLUMNS) - 1u) << (4u - side)) & 255u;
    var words: Words;
    var last = vec4(0u);
    for (var p = 0u; p < IMAGE_PLANES; p++) {
        if p < CENSUS_ROWS {
            let bits = census_row(x, y, i32(p) - i32(CENSUS_ABOVE));
            words[p] = bits.eight & vec4(columns * 0x01010101u);
            last |= bits.ninth << vec4(p);
        }
    }
    if CENSUS_COLUMNS == 9u {
        if CENSUS == CENSUS_SYMMETRIC {
            last |= (census_row(x, y, 0).eight & vec4(0x0f0f0f0fu)) << vec4(3u);
        }
        words[min(CENSUS_ROWS, IMAGE_PLANES - 1u)] = last;
    }
    return words;
}

fn clipped(gradient: vec4<i32>) -> u32 {
    let cap = vec4(i32(frame.prefilter_cap));
    return pack(vec4<u32>(clamp(gradient, -cap, cap) + cap));
}

// The values of four pixels from column x on, less the mean of the block, rounded, halves upwards.
fn excess(values: vec4<i32>, x: i32, y: i32) -> u32 {
    let columns = vec4<u32>(clamp(vec4(x) + vec4(0, 1, 2, 3), vec4(0), vec4(i32(frame.width) - 1)));
    let at = vec4(u32(y) * frame.width) + columns;
    let sum = vec4<i32>(vec4(sums[at.x], sums[at.y], sums[at.z], sums[at.w]));
    let n = i32(BLOCK * BLOCK);
    let half = n * select(1, 257, DEEP == 1u);
    let rounded = mean_in_levels(2 * (n * values - sum) + vec4(half), 2 * n);
    return pack(vec4<u32>(clamp(rounded, vec4(-127), vec4(127)) + vec4(127)));
}

// Three planes of four pixels, in the middle of columns k .. k + 2 of the rows, k = 4 i .. 4 i + 3, from column x + 4 i on:
// what the cost wants beside a census.
fn others(above: Pixels, here: Pixels, below: Pixels, i: u32, x: i32, y: i32) -> vec3<u32> {
    let values = vec4(here[i].yzw, here[i + 1u].x);
    if DESCRIPTOR == DESCRIPTOR_GRADIENTS {
        return vec3(clipped(sobel_x(above, here, below, i)), clipped(sobel_y(above, below, i)), 0u);
    }
    if DESCRIPTOR == DESCRIPTOR_EXCESS {
        return vec3(excess(values, x + i32(4u * i), y), 0u, 0u);
    }
    let v = vec4<u32>(in_levels(values));
    if DESCRIPTOR != DESCRIPTOR_INTERVAL {
        return vec3(pack(v), 0u, 0u);
    }
    let before = (v + vec4<u32>(in_levels(here[i]))) >> vec4(1u);
    let after = (v + vec4<u32>(in_levels(vec4(here[i].zw, here[i + 1u].xy)))) >> vec4(1u);
    return vec3(pack(v), pack(min(v, min(before, after))), pack(max(v, max(before, after))));
}

// The bytes of the sixteen pixels from column x on, which is -15 or more.
fn descriptors(x: i32, y: i32) -> Words {
    var words: Words;
    if CENSUS_PLANES > 0u {
        words = census(x, y);
    }
    if CENSUS_PLANES < IMAGE_PLANES {
        let above = pixels_from(x - 1, y - 1);
        let here = pixels_from(x - 1, y);
        let below = pixels_from(x - 1, y + 1);
        let a = others(above, here, below, 0u, x, y);
        let b = others(above, here, below, 1u, x, y);
        let c = others(above, here, below, 2u, x, y);
        let d = others(above, here, below, 3u, x, y);
        words[min(CENSUS_PLANES, IMAGE_PLANES - 1u)] = vec4(a.x, b.x, c.x, d.x);
        if CENSUS_PLANES + 1u < IMAGE_PLANES {
            words[min(CENSUS_PLANES + 1u, IMAGE_PLANES - 1u)] = vec4(a.y, b.y, c.y, d.y);
        }
        if CENSUS_PLANES + 2u < IMAGE_PLANES {
            words[min(CENSUS_PLANES + 2u, IMAGE_PLANES - 1u)] = vec4(a.z, b.z, c.z, d.z);
        }
    }
    return words;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let mirrored = dispatch.own.mirrored == 1u;
    let stride = dispatch.stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let x = lowest_column(id.x, mirrored);
    var words = descriptors(x, i32(dispatch.first_row + id.y));
    for (var p = 0u; p < IMAGE_PLANES; p++) {
        let row = (dispatch.own.first_plane + p) * dispatch.rows + id.y;
        planes[row * stride + id.x] = laid_out(words[p], x, mirrored);
    }
}
