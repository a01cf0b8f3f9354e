// Appended to the convolutions whose input is one image or volume: where a line of it begins, and which columns there are.

fn place_of(block: u32, z: u32, y: u32) -> u32 {
    let line = (z * dispatch.own.in_rows + y) * dispatch.own.in_columns;
    return dispatch.own.at + block * dispatch.own.in_stride + line;
}

fn reaches(x: u32, z: u32) -> bool {
    return x < dispatch.own.in_columns;
}
