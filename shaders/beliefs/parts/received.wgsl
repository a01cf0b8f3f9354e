// Appended to the kernels that read messages: those that a pixel receives. A buffer holds four volumes of a band's rows one after
// the other: the messages that its pixels send up, down, left and right. Nothing comes from beyond the image: 0.

struct Own {
    width: u32,     // of the images of this level
    height: u32,
    stride: u32,    // pixels a row of a volume
    first: u32,     // the first row of the band
    rows: u32,      // of the band
    above: u32,     // pixels before the last row of those sent down in the band above
    odd: u32,       // 1: the pixels that send are those of which column and row add up to an odd number
    share: u32,     // of a belief that is sent, in sixteenths
}

// The ways along which a pixel sends: the volumes of a buffer.
const UP: u32 = 0u;
const DOWN: u32 = 1u;
const LEFT: u32 = 2u;
const RIGHT: u32 = 3u;

// Where a member's slice s of what a pixel of the band sends along a way lies.
fn sent_at(way: u32, pixel: u32, s: u32) -> u32 {
    return slice_at(way * dispatch.own.rows * dispatch.own.stride + pixel, s);
}

fn from_above(x: u32, row: u32, s: u32) -> Slice {
    if row > 0u {
        return slice_of(messages[sent_at(DOWN, (row - 1u) * dispatch.own.stride + x, s)]);
    }
    if dispatch.own.first > 0u {
        return slice_of(above[slice_at(dispatch.own.above + x, s)]);
    }
    return Slice();
}

fn from_below(x: u32, row: u32, s: u32) -> Slice {
    if row + 1u < dispatch.own.rows {
        return slice_of(messages[sent_at(UP, (row + 1u) * dispatch.own.stride + x, s)]);
    }
    if dispatch.own.first + row + 1u < dispatch.own.height {
        return slice_of(below[slice_at(x, s)]);
    }
    return Slice();
}

fn from_left(x: u32, row: u32, s: u32) -> Slice {
    if x > 0u {
        return slice_of(messages[sent_at(RIGHT, row * dispatch.own.stride + x - 1u, s)]);
    }
    return Slice();
}

fn from_right(x: u32, row: u32, s: u32) -> Slice {
    if x + 1u < dispatch.own.width {
        return slice_of(messages[sent_at(LEFT, row * dispatch.own.stride + x + 1u, s)]);
    }
    return Slice();
}
