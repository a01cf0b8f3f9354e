// Appended to the layers of 3x3 pixels: rows and columns around those of an invocation, clamped into the image.

// The row of the values that lies dy rows below the row before row `row` of the results.
fn row_below(row: u32, dy: u32) -> u32 {
    let y = clamp(i32(dispatch.first_row + row + dy) - 1, 0, i32(frame.height) - 1);
    return min(u32(y) - dispatch.own.in_first, dispatch.own.in_rows - 1u);
}

// Six columns from the one before a vector's first on, four channels each.
fn six_columns(block: u32, row: u32, vector: u32) -> array<u32, 6> {
    let start = (block * dispatch.own.in_rows + row) * row_vectors();
    let here = values[start + vector];
    let before = values[start + max(vector, 1u) - 1u].w;
    let after = values[start + min(vector + 1u, row_vectors() - 1u)].x;
    return array(select(before, here.x, vector == 0u), here.x, here.y, here.z, here.w,
        select(after, here.w, vector + 1u == row_vectors()));
}
