// penalties_lines: as penalties, with q = p - (dx, dy) in a direction that crosses rows. Where a line leaves the image at a
//   side it goes on at the other one; there, and in the first rows, q lies outside.
// gray (u8, in a texture) -> penalties (PENALTY_BYTES a pixel, s pixels a vector, [place / s][row of entry][line][place % s];
//   a line is named by its column there)
// One invocation: sixteen pixels of a line. Border: places behind the last one repeat the last row.
// With: intensity_steps, common
// Reference: src/reference/paths/penalties.rs

// The image's rows begin with column -16.
fn gray_of(x: u32, y: u32) -> u32 {
    let words = gray_at(y * frame.gray_stride + x / 16u + 1u);
    let two = select(words.xy, words.zw, (x & 8u) != 0u);
    return (select(two.x, two.y, (x & 4u) != 0u) >> (8u * (x & 3u))) & 255u;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width {
        return;
    }
    let rows = u32(dispatch.dy);
    let width = i32(frame.width);
    // Of the pixel before the first one.
    var y = i32(id.y / rows * 16u * rows + id.y % rows) - dispatch.dy;
    let moved = dispatch.dx * (i32(id.y / rows * 16u) - 1);
    let turn = u32(abs(moved)) % frame.width;
    var x = i32((id.x + select(turn, frame.width - turn, moved < 0)) % frame.width);
    var before = gray_of(u32(x), u32(max(y, 0)));
    var bytes: Sixteen;
    for (var i = 0u; i < 4u; i++) {
        var here = vec4(0u);
        var last = vec4(0u);
        var outside = vec4(false);
        for (var j = 0u; j < 4u; j++) {
            let starts = y < 0;
            y += dispatch.dy;
            x += dispatch.dx;
            let leaves = x < 0 || x >= width;
            x -= select(0, select(-width, width, x >= width), leaves);
            last[j] = before;
            before = gray_of(u32(x), min(u32(y), frame.height - 1u));
            here[j] = before;
            outside[j] = starts || leaves;
        }
        put(&bytes, i, here, last, outside);
    }
    for (var j = 0u; j < PENALTY_BYTES; j++) {
        let row = (id.y / rows * PENALTY_BYTES + j) * rows + id.y % rows;
        penalties[row * frame.width + id.x] = stored(bytes[j]);
    }
}
