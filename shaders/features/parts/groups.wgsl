// Appended to the layers that sum over all channels: what an invocation sums, GROUPS groups of eight channels of four columns. The
// weights of a group: for each of its channels a texel with its bias, multiplier and shift; then step by step a texel for each, of four words
// with the weights of four input channels. What the four words of a step stand for is the kernel's.

alias Sums = array<array<Sum, 4>, 8u * GROUPS>;
alias Texels = array<array<vec4<u32>, 8>, GROUPS>;

// Where an invocation works. All invocations go through all loops: neighbours may give weights to each other.
struct Place {
    vector: u32,
    row: u32,
    idle: bool,
}

fn place_of(line: u32) -> Place {
    let row = line / row_vectors();
    return Place(line % row_vectors(), min(row, dispatch.rows - 1u), row >= dispatch.rows);
}

// Step 0 are biases, multipliers and shifts.
fn texels_at(group: u32, steps: u32, step: u32, lane: u32) -> Texels {
    let last = (dispatch.own.out_blocks + 1u) / 2u - 1u;
    var texels: Texels;
    for (var g = 0u; g < GROUPS; g++) {
        texels[g] = eight_texels(dispatch.own.weights + (min(group + g, last) * (steps + 1u) + step) * 8u, lane);
    }
    return texels;
}

fn begun(group: u32, steps: u32, lane: u32) -> Sums {
    var texels = texels_at(group, steps, 0u, lane);
    var sums: Sums;
    for (var g = 0u; g < GROUPS; g++) {
        for (var o = 0u; o < 8u; o++) {
            for (var c = 0u; c < 4u; c++) {
                sums[8u * g + o][c] = Sum(bitcast<i32>(texels[g][o].x));
            }
        }
    }
    return sums;
}

// Adds the products of four columns with word k of a step.
fn add(columns: vec4<u32>, k: u32, step: Texels, sums: ptr<function, Sums>) {
    var texels = step;
    let inputs = array(four_of(columns.x), four_of(columns.y), four_of(columns.z), four_of(columns.w));
    for (var g = 0u; g < GROUPS; g++) {
        for (var o = 0u; o < 8u; o++) {
            let taps = four_of(texels[g][o][k]);
            for (var c = 0u; c < 4u; c++) {
                (*sums)[8u * g + o][c] = plus_products((*sums)[8u * g + o][c], taps, inputs[c]);
            }
        }
    }
}

fn leave_sums(place: Place, group: u32, steps: u32, lane: u32, finished: Sums) {
    var sums = finished;
    var texels = texels_at(group, steps, 0u, lane);
    for (var g = 0u; g < GROUPS; g++) {
        for (var b = 0u; b < 2u; b++) {
            let block = 2u * (group + g) + b;
            let numbers = array(texels[g][4u * b], texels[g][4u * b + 1u], texels[g][4u * b + 2u], texels[g][4u * b + 3u]);
            let multipliers = vec4(numbers[0].y, numbers[1].y, numbers[2].y, numbers[3].y);
            let shifts = vec4(numbers[0].z, numbers[1].z, numbers[2].z, numbers[3].z);
            var columns = array<vec4<i32>, 4>();
            for (var c = 0u; c < 4u; c++) {
                let first = 8u * g + 4u * b;
                let four = vec4(i32(sums[first][c]), i32(sums[first + 1u][c]), i32(sums[first + 2u][c]), i32(sums[first + 3u][c]));
                columns[c] = requantised(four, multipliers, shifts);
            }
            if !place.idle && block < dispatch.own.out_blocks {
                leave(block, place.row, place.vector, columns);
            }
        }
    }
}
