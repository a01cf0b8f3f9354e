// window_sums: sums over the dispatch.own.window x dispatch.own.window pixels around a pixel.
// columns (u32, [y][x], the sums of columns) -> sums (u32, [y][x])
// One invocation: SEGMENT pixels of a row, to the right; a column enters the sum as another leaves it.
// Border: columns are clamped into the image.
// With: common
// Reference: src/reference/images/window_sums.rs

struct Own {
    window: u32,        // side of the window
}

@group(0) @binding(2) var<storage, read> columns: array<u32>;
@group(0) @binding(3) var<storage, read_write> sums: array<u32>;

fn column_at(row: u32, x: i32) -> u32 {
    return columns[row + u32(clamp(x, 0, i32(frame.width) - 1))];
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.x;
    let begin = id.y * SEGMENT;
    if y >= frame.height || begin >= frame.width {
        return;
    }
    let row = y * frame.width;
    let radius = i32(dispatch.own.window / 2u);
    let first = i32(begin);
    var sum = 0u;
    for (var dx = -radius - 1; dx < radius; dx++) {
        sum += column_at(row, first + dx);
    }
    for (var x = first; x < i32(min(begin + SEGMENT, frame.width)); x++) {
        sum += column_at(row, x + radius) - column_at(row, x - 1 - radius);
        sums[row + u32(x)] = sum;
    }
}
