// Appended to the convolutions: what they know of their operation, and how its results are stored.

struct Own {
    columns: u32,      // of the output
    rows: u32,
    planes: u32,
    in_columns: u32,
    in_rows: u32,
    in_planes: u32,
    blocks: u32,       // of four channels that are read, of all dispatches
    first_in: u32,     // those of this dispatch: from which
    end_in: u32,       // and before which
    in_stride: u32,    // texels a block that is read
    out_stride: u32,   // texels a block that is written
    at: u32,           // the texel that block 0 begins with, of what is read; it may lie before what is bound, below zero
    added_at: u32,     // the same of what is added
    weights: u32,      // the first texel of the weights, which is the first bias
    first_block: u32,  // of the output, of this dispatch
    out_blocks: u32,   // of all dispatches
    flags: u32,        // 1: values are added; 2: negative results become 0; 4: the sums begin with those of the dispatch before
}

// Columns of the output that an invocation computes.
const COLUMNS: u32 = 6u;

// What an invocation computes.
struct Task {
    x: u32,            // the first column
    y: u32,
    z: u32,
    block: u32,        // of the output
    idle: bool,
}

fn task_of(id: vec3<u32>) -> Task {
    let groups = (dispatch.own.columns + COLUMNS - 1u) / COLUMNS;
    let y = id.x / groups;
    let block = dispatch.own.first_block + id.y / dispatch.own.planes;
    return Task((id.x % groups) * COLUMNS, y, id.y % dispatch.own.planes, block, y >= dispatch.own.rows);
}

// The texel of the output that an invocation's first column lies at.
fn first_of(task: Task) -> u32 {
    let line = (task.z * dispatch.own.rows + task.y) * dispatch.own.columns;
    return (task.block - dispatch.own.first_block) * dispatch.own.out_stride + line + task.x;
}

// What the sums begin with: the bias, or what the dispatch before left.
fn begun(task: Task) -> array<vec4<f32>, COLUMNS> {
    var sums: array<vec4<f32>, COLUMNS>;
    let bias = weight_at(dispatch.own.weights + task.block);
    for (var c = 0u; c < COLUMNS; c++) {
        sums[c] = bias;
    }
    if (dispatch.own.flags & 4u) != 0u {
        for (var c = 0u; c < COLUMNS; c++) {
            if !task.idle && task.x + c < dispatch.own.columns {
                sums[c] = result[first_of(task) + c];
            }
        }
    }
    return sums;
}

fn store(task: Task, sums: array<vec4<f32>, COLUMNS>) {
    var results = sums;
    let first = first_of(task);
    let added = dispatch.own.added_at + dispatch.own.first_block * dispatch.own.out_stride;
    for (var c = 0u; c < COLUMNS; c++) {
        if !task.idle && task.x + c < dispatch.own.columns {
            var value = results[c];
            if (dispatch.own.flags & 1u) != 0u {
                value += added_at(added + first + c);
            }
            if (dispatch.own.flags & 2u) != 0u {
                value = max(value, vec4(0.0));
            }
            result[first + c] = value;
        }
    }
}
