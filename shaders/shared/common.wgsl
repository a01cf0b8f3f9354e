// Appended to every kernel: the two uniform blocks (src/gpu/layout/uniforms.rs holds their Rust twins) and the packed formats.

// What stays the same for all dispatches of a frame.
struct Frame {
    width: u32,
    height: u32,
    min_disparity: i32,
    block_radius: u32,
    prefilter_cap: u32,
    cost_scale: u32,
    p1: u32,
    p2: u32,
    lr_max_difference: u32,
    gray_stride: u32,     // vectors of 16 bytes a row of a gray image
    left_stride: u32,     // words a row of the left planes
    right_stride: u32,    // words a row of the right planes
    map_stride: u32,      // words a row of a disparity map, a multiple of 4
    volume_stride: u32,   // pixels a row of a volume
    map_words: u32,       // words of a map, from the right one to what lies behind it
    texture: u32,         // the least texture of a block
    speckle_window: u32,
    speckle_range: i32,   // 1/16 px
    fill_max_difference: i32, // px
    depth_high: u32,      // 4096 focal * baseline, in millionths
    depth_low: u32,
    depth_offset: i32,    // doffs in 1/4096 px
    source_shift: u32,    // bits of a texel's column in an uploaded image
}

// What differs between dispatches.
struct Dispatch {
    first_row: u32,       // in the image; where rows of buffers are bound, they begin with it
    rows: u32,            // number of rows to process; for a path that crosses rows, of rows that it visits
    volume_row: u32,      // row of the volume's buffer that holds first_row
    first_line: u32,      // of the paths of a direction
    lines: u32,
    shift: u32,           // columns from a line's number to where its path enters
    dx: i32,              // direction of aggregation
    dy: i32,
    entry: i32,           // row of the band at which paths enter
    carried: u32,         // 1: carry_in holds the path costs of the band before this one
    stride: u32,          // words a row of the planes
    row_step: u32,        // rows between two borders of bands, or between two pixels of a line
    slot: u32,            // offset in pixels of the volume that is written, or stride between volumes in a buffer
    map_row: u32,         // index of first_row among the bound rows of the maps
    planes_row: u32,      // the row of the image with which the planes begin
    planes_rows: u32,     // rows of a plane
    own: Own,             // fields of this kernel alone, declared by it or its fragments; else an unused number
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> dispatch: Dispatch;

// Four bytes, the lowest first.
fn unpack(word: u32) -> vec4<u32> {
    return (vec4(word) >> vec4(0u, 8u, 16u, 24u)) & vec4(255u);
}

fn pack(v: vec4<u32>) -> u32 {
    return v.x | (v.y << 8u) | (v.z << 16u) | (v.w << 24u);
}

// Four values of 16 bits from two words: one holds the even two, the other the odd two.
fn unpack_pairs(even: u32, odd: u32) -> vec4<u32> {
    return vec4(even & 0xffffu, odd & 0xffffu, even >> 16u, odd >> 16u);
}

fn lowest(v: vec4<u32>) -> u32 {
    return min(min(v.x, v.y), min(v.z, v.w));
}

// A disparity map holds two pixels a word, 1/16 px each, the left one in the low half.
const INVALID: i32 = -32768;

fn map_value(word: u32, x: u32) -> i32 {
    return extractBits(bitcast<i32>(word), (x & 1u) * 16u, 16u);
}

fn map_word(low: i32, high: i32) -> u32 {
    return (bitcast<u32>(low) & 0xffffu) | (bitcast<u32>(high) << 16u);
}

// Whether a disparity at column x of the left image points into the right image.
fn points_inside(x: i32, disparity: i32) -> bool {
    let seen = x - ((disparity + 8) >> 4u);
    return seen >= 0 && seen < i32(frame.width);
}
