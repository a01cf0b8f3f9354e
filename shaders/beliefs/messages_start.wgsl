// messages_start: the messages with which a level begins: a pixel has received what one of 2 x 2 pixels has at the level before;
//   at the coarsest level nothing.
// coarse (u8, four volumes [y][x][d]: up, down, left, right) -> messages, laid out alike
//   above, below: the coarse messages of the bands next to this one.
// One invocation: 16 * WIDTH disparities of what a pixel sends.
// Border: nothing comes from beyond the coarse images: 0.
// With: common
// Chosen: volume*
// Reference: src/reference/beliefs/messages.rs

struct Own {
    rows: u32,          // of the band
    stride: u32,        // pixels a row of a volume
    coarse_width: u32,  // of the level before; 0 if there is none
    coarse_height: u32,
    coarse_stride: u32,
    coarse_first: u32,  // the first row of the band there
    coarse_rows: u32,
    above: u32,         // pixels before the last row of those sent down in the band above
}

@group(0) @binding(2) var<storage, read> coarse: array<Stored>;
@group(0) @binding(3) var<storage, read> above: array<Stored>;
@group(0) @binding(4) var<storage, read> below: array<Stored>;
@group(0) @binding(5) var<storage, read_write> messages: array<Stored>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= dispatch.lines {
        return;
    }
    let slices = QUADS / WIDTH;
    let x = id.x / slices;
    let s = id.x % slices;
    let volume = dispatch.own.rows * dispatch.own.stride;
    let pixel = id.y * dispatch.own.stride + x;
    messages[pixel * slices + s] = sent_up(x / 2u, (id.y + 1u) / 2u, s);
    messages[(volume + pixel) * slices + s] = sent_down(x / 2u, (id.y + 1u) / 2u, s);
    messages[(2u * volume + pixel) * slices + s] = sent_left((x + 1u) / 2u, id.y / 2u, s);
    messages[(3u * volume + pixel) * slices + s] = sent_right((x + 1u) / 2u, id.y / 2u, s);
}

fn coarse_at(way: u32, x: u32, row: u32, s: u32) -> Stored {
    let pixel = (way * dispatch.own.coarse_rows + row) * dispatch.own.coarse_stride + x;
    return coarse[pixel * (QUADS / WIDTH) + s];
}

// By the pixel of a column and a row of the band.
fn sent_up(x: u32, row: u32, s: u32) -> Stored {
    if row < dispatch.own.coarse_rows {
        return coarse_at(0u, x, row, s);
    }
    if dispatch.own.coarse_first + row < dispatch.own.coarse_height {
        return below[x * (QUADS / WIDTH) + s];
    }
    return Stored();
}

// By the pixel above a row.
fn sent_down(x: u32, row: u32, s: u32) -> Stored {
    if row > 0u && dispatch.own.coarse_rows > 0u {
        return coarse_at(1u, x, row - 1u, s);
    }
    if dispatch.own.coarse_first > 0u {
        return above[(dispatch.own.above + x) * (QUADS / WIDTH) + s];
    }
    return Stored();
}

fn sent_left(x: u32, row: u32, s: u32) -> Stored {
    if x < dispatch.own.coarse_width {
        return coarse_at(2u, x, row, s);
    }
    return Stored();
}

// By the pixel to the left of a column.
fn sent_right(x: u32, row: u32, s: u32) -> Stored {
    if x > 0u && dispatch.own.coarse_width > 0u {
        return coarse_at(3u, x - 1u, row, s);
    }
    return Stored();
}
