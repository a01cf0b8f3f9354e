// Appended to the kernels that make images of other sizes: what they know of their operation.

struct Own {
    columns: u32,      // of the output
    rows: u32,
    in_columns: u32,
    in_rows: u32,
    in_stride: u32,    // texels a block that is read
    in_at: u32,        // the first texel that is read
    out_stride: u32,   // texels a block that is written
    rule: u32,         // the side of a square; or 1: the corner pixels lie on each other
}
