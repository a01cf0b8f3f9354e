// Appended to the kernels of lines that go dx columns to the right from row to row.

// Where the nearest values on a group of eight lines lie; a line is named by its column in row 0.
fn slot_of(group: i32, y: i32, dx: i32) -> u32 {
    return u32((y - i32(dispatch.first_row)) * i32(frame.map_stride / 4u + 1u) + group - ((-dx * y) >> 3u));
}
