// Appended to the convolutions: what they know of their operation, and how its results are stored.

struct Own {
    columns: u32,      // of the output
    rows: u32,
    planes: u32,
    in_columns: u32,
    in_rows: u32,
    in_planes: u32,
    blocks: u32,       // of four channels that are read
    in_stride: u32,    // texels a block that is read
    out_stride: u32,   // texels a block that is written
    at: u32,           // the first texel that is read
    added_at: u32,     // the first texel that is added
    weights: u32,      // the first texel of the weights, which is the first bias
    first_block: u32,  // of the output, of this dispatch
    out_blocks: u32,   // of all dispatches
    flags: u32,        // 1: values are added; 2: negative results become 0
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

fn store(task: Task, sums: array<vec4<f32>, COLUMNS>) {
    var results = sums;
    let within = (task.z * dispatch.own.rows + task.y) * dispatch.own.columns + task.x;
    for (var c = 0u; c < COLUMNS; c++) {
        if !task.idle && task.x + c < dispatch.own.columns {
            var value = results[c];
            if (dispatch.own.flags & 1u) != 0u {
                value += added_at(dispatch.own.added_at + task.block * dispatch.own.out_stride + within + c);
            }
            if (dispatch.own.flags & 2u) != 0u {
                value = max(value, vec4(0.0));
            }
            let block = task.block - dispatch.own.first_block;
            result[block * dispatch.own.out_stride + within + c] = value;
        }
    }
}
