// winner: the disparity of the smallest S(d) = PATHS C(d) + sum of T(d) over all directions; the right view likewise.
// cost, the T of all directions but the leftward one (pairs in a byte; u8, [y][x][d]) -> left_map, right_map (i16)
//   The leftward direction of sgm_aggregate is walked here, so its T is never stored. PAIRED volumes hold two
//   directions each, `forward` holds the rightward one.
// One invocation: one row of the band, from right to left.
// Reference: src/reference/winner.rs, src/reference/sgm_aggregate.rs

@group(0) @binding(2) var cost: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(3) var<storage, read> forward: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> paired0: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> paired1: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read> paired2: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read_write> left_map: array<u32>;
@group(0) @binding(8) var<storage, read_write> right_map: array<u32>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= pass_.rows {
        return;
    }
    let row = pass_.first_row + id.x;
    var state: State;
    var costs: Costs;
    var diagonal = no_costs(0xffffffffu);
    var kept = RowWriter(INVALID, INVALID);
    let steps = row_steps();
    for (var i = 0; i < steps; i++) {
        let x = row_start() - i;
        if inside_row(x) {
            walk(&state, &costs, (id.x * frame.width + u32(x)) * QUADS);
        }
        choose(&costs, &diagonal, &kept, row, x);
    }
}

// One step of the leftward path, and S of the pixel.
fn walk(state: ptr<function, State>, costs: ptr<function, Costs>, at: u32) {
    let least = path_minimum(state);
    var below = NONE;
    for (var q = 0u; q < QUADS; q++) {
        let c = cost_at(at + q);
        let t = path_quad(state, q, c, least, &below);
        let t0 = forward[at + q];
        let t1 = paired0[at + q];
        // Sums of bytes in the 16-bit halves of words.
        var even = PATHS * evens(c) + evens(t) + evens(t0) + evens(t1);
        var odd = PATHS * odds(c) + odds(t) + odds(t0) + odds(t1);
        if PAIRED == 3u {
            let t2 = paired1[at + q];
            let t3 = paired2[at + q];
            even += evens(t2) + evens(t3);
            odd += odds(t2) + odds(t3);
        }
        (*costs)[q][0] = unpack_pairs(even.x, odd.x);
        (*costs)[q][1] = unpack_pairs(even.y, odd.y);
        (*costs)[q][2] = unpack_pairs(even.z, odd.z);
        (*costs)[q][3] = unpack_pairs(even.w, odd.w);
    }
}

fn evens(words: vec4<u32>) -> vec4<u32> {
    return words & vec4(0xff00ffu);
}

fn odds(words: vec4<u32>) -> vec4<u32> {
    return (words >> vec4(8u)) & vec4(0xff00ffu);
}
