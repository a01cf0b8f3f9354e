// Appended to the kernels that send messages. A message to a neighbour is, for each of its disparities, the least sum of a share of the
// sender's belief, less what the neighbour itself has sent, and of the smoothness; less the smallest of these.
// Reference: src/reference/beliefs/messages.rs

// Disparities of a member.
const OWN: u32 = 16u * OWN_QUADS;

alias Message = array<Slice, SLICES>;

// Shares of a pixel's belief, of a member.
alias Belief = array<Pairs, OWN_QUADS>;

fn send(x: u32, row: u32, writes: bool) {
    let pixel = row * dispatch.own.stride + x;
    var up: Message;
    var down: Message;
    var left: Message;
    var right: Message;
    var belief: Belief;
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
            let vertical = sum_of(pairs_of(up[s][w]), pairs_of(down[s][w]));
            let horizontal = sum_of(pairs_of(left[s][w]), pairs_of(right[s][w]));
            let sums = sum_of(data[w], sum_of(vertical, horizontal));
            let outside = pairs_of(beyond(s * WIDTH + w));
            belief[s * WIDTH + w] = Pairs(share_of(sums.even) | (outside.even * 0x101u), share_of(sums.odd) | (outside.odd * 0x101u));
        }
    }
    let edges = edges_at(x, dispatch.own.first + row);
    let to_up = message(&belief, up, edges.x);
    let to_down = message(&belief, down, edges.y);
    let to_left = message(&belief, left, edges.z);
    let to_right = message(&belief, right, edges.w);
    if !writes {
        return;
    }
    for (var s = 0u; s < SLICES; s++) {
        if in_volume(s * WIDTH) {
            // What is sent beyond the image nobody reads.
            messages[sent_at(UP, pixel, s)] = stored_messages(to_up[s]);
            messages[sent_at(DOWN, pixel, s)] = stored_messages(to_down[s]);
            messages[sent_at(LEFT, pixel, s)] = stored_messages(to_left[s]);
            messages[sent_at(RIGHT, pixel, s)] = stored_messages(to_right[s]);
        }
    }
}

// Of two sums of at most 2555: times 16 they do not meet. 128 keep what is sent from being negative; what is beyond the range of
// disparities becomes the largest.
fn share_of(sums: vec4<u32>) -> vec4<u32> {
    return (((sums * dispatch.own.share) >> vec4(4u)) & vec4(0xfff0fffu)) + vec4(0x800080u);
}

fn message(belief: ptr<function, Belief>, received: Message, edge: u32) -> Message {
    var values: Costs;
    var least = vec4(FAR);
    for (var s = 0u; s < SLICES; s++) {
        for (var w = 0u; w < WIDTH; w++) {
            let q = s * WIDTH + w;
            let other = pairs_of(received[s][w]);
            let even = (*belief)[q].even - other.even;
            let odd = (*belief)[q].odd - other.odd;
            for (var i = 0u; i < 4u; i++) {
                let v = unpack_pairs(even[i], odd[i]);
                values[q][i] = v;
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
