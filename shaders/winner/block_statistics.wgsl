// block_statistics: of the values v of each block their sum s, and floor(sqrt(n * sum of v^2 - s^2)), n pixels a block.
// plane (descriptors of one side) -> statistics (pairs of u32, [y][left, then right blocks], only the band's rows)
//   Left blocks from column 0 on; right ones leftwards, from what the last column sees at the smallest disparity.
// One invocation: four neighbouring blocks, SEGMENT rows downwards; a row enters the sums as another leaves them.
// Border: rows are clamped into the image, columns by the planes.
// With: root, common
// Reference: src/reference/winner/block_statistics.rs

@group(0) @binding(2) var<storage, read> plane: array<u32>;
@group(0) @binding(3) var<storage, read_write> statistics: array<vec2<u32>>;

// The sums of four blocks, and those of their squares.
struct Sums {
    values: vec4<u32>,
    squares: vec4<u32>,
}

// The sums over the rows of four blocks, whose first bytes are those of word `at`.
fn row_sums(at: u32, y: i32) -> Sums {
    let row = (u32(clamp(y, 0, i32(frame.height) - 1)) - dispatch.planes_row) * dispatch.stride;
    var sums: Sums;
    for (var w = 0u; w < BLOCK_WORDS; w++) {
        let values = unpack(plane[row + min(at + w, dispatch.stride - 1u)]);
        for (var i = 0u; i < 4u; i++) {
            // Byte j belongs to the blocks that begin at most j and more than j - BLOCK bytes on.
            let j = 4u * w + i;
            let belongs = (vec4(j) >= vec4(0u, 1u, 2u, 3u)) & (vec4(j) < vec4(0u, 1u, 2u, 3u) + vec4(BLOCK));
            let own = select(vec4(0u), vec4(values[i]), belongs);
            sums.values += own;
            sums.squares += own * values[i];
        }
    }
    return sums;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let first = 4u * id.x;
    let begin = id.y * SEGMENT;
    if first >= dispatch.lines || begin >= dispatch.rows {
        return;
    }
    let r = i32(frame.block_radius);
    let y = i32(dispatch.first_row + begin);
    var sums: Sums;
    for (var j = -r; j <= r; j++) {
        let enters = row_sums(id.x, y - 1 + j);
        sums = Sums(sums.values + enters.values, sums.squares + enters.squares);
    }
    for (var line = begin; line < min(begin + SEGMENT, dispatch.rows); line++) {
        let here = i32(dispatch.first_row + line);
        let enters = row_sums(id.x, here + r);
        let leaves = row_sums(id.x, here - 1 - r);
        sums.values += enters.values - leaves.values;
        sums.squares += enters.squares - leaves.squares;
        // Products modulo 2^32; the difference itself is below 2^31.
        let spread = BLOCK * BLOCK * sums.squares - sums.values * sums.values;
        let at = line * (2u * frame.width + DISPARITIES - 1u) + dispatch.first_line + first;
        for (var i = 0u; i < 4u; i++) {
            if first + i < dispatch.lines {
                statistics[at + i] = vec2(sums.values[i], integer_root(spread[i]));
            }
        }
    }
}
