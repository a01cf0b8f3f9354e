// Appended to the kernels that send messages. A message to a neighbour is, for each of its disparities, the least sum of a share of the
// sender's belief, less what the neighbour itself has sent, and of the smoothness; less the smallest of these.
// Reference: src/reference/beliefs/messages.rs

// Disparities of a member.
const OWN: u32 = 16u * OWN_QUADS;

alias Message = array<Slice, SLICES>;

// The data terms of a slice.
alias Data = array<array<vec4<u32>, 4>, WIDTH>;

fn send(x: u32, row: u32, writes: bool) {
    let pixel = row * dispatch.own.stride + x;
    var up: Message;
    var down: Message;
    var left: Message;
    var right: Message;
    var belief: Costs;
    for (var s = 0u; s < SLICES; s++) {
        var data = Data();
        if in_volume(s * WIDTH) {
            data = data_at(slice_at(pixel, s));
            up[s] = from_above(x, row, s);
            down[s] = from_below(x, row, s);
            left[s] = from_left(x, row, s);
            right[s] = from_right(x, row, s);
        }
        for (var w = 0u; w < WIDTH; w++) {
            let q = s * WIDTH + w;
            for (var i = 0u; i < 4u; i++) {
                let sum = data[w][i] + unpack(up[s][w][i]) + unpack(down[s][w][i]) + unpack(left[s][w][i]) + unpack(right[s][w][i]);
                // 128 keep what is sent from being negative.
                let part = ((sum * dispatch.own.share) >> vec4(4u)) + vec4(128u);
                belief[q][i] = select(part, vec4(FAR), unpack(beyond(q)[i]) != vec4(0u));
            }
        }
    }
    let y = dispatch.own.first + row;
    let edges = edges_at(x, y);
    let to_up = message(&belief, up, edges.x);
    let to_down = message(&belief, down, edges.y);
    let to_left = message(&belief, left, edges.z);
    let to_right = message(&belief, right, edges.w);
    if !writes {
        return;
    }
    for (var s = 0u; s < SLICES; s++) {
        if in_volume(s * WIDTH) {
            if y > 0u {
                messages[sent_at(UP, pixel, s)] = stored_terms(to_up[s]);
            }
            if y + 1u < dispatch.own.height {
                messages[sent_at(DOWN, pixel, s)] = stored_terms(to_down[s]);
            }
            if x > 0u {
                messages[sent_at(LEFT, pixel, s)] = stored_terms(to_left[s]);
            }
            if x + 1u < dispatch.own.width {
                messages[sent_at(RIGHT, pixel, s)] = stored_terms(to_right[s]);
            }
        }
    }
}

fn message(belief: ptr<function, Costs>, received: Message, edge: u32) -> Message {
    var values: Costs;
    var least = vec4(FAR);
    for (var s = 0u; s < SLICES; s++) {
        for (var w = 0u; w < WIDTH; w++) {
            for (var i = 0u; i < 4u; i++) {
                let v = (*belief)[s * WIDTH + w][i] - unpack(received[s][w][i]);
                values[s * WIDTH + w][i] = v;
                least = min(least, v);
            }
        }
    }
    let smallest = exchange(lowest(least), 0u, 0u).least;
    for (var q = 0u; q < OWN_QUADS; q++) {
        for (var i = 0u; i < 4u; i++) {
            values[q][i] = min(values[q][i] - vec4(smallest), vec4(SMOOTHNESS_TRUNCATION >> (edge & 1u)));
        }
    }
    smoothed(&values, SMOOTHNESS_WEIGHT >> (edge & 1u));
    var sent: Message;
    for (var s = 0u; s < SLICES; s++) {
        for (var w = 0u; w < WIDTH; w++) {
            let v = values[s * WIDTH + w];
            sent[s][w] = vec4(pack(v[0]), pack(v[1]), pack(v[2]), pack(v[3]));
        }
    }
    return sent;
}
