// winner: the disparity of the smallest S(d) = PATHS C(d) + sum of T(d) over all directions; the right view likewise.
// cost, the T of all directions but the leftward one (pairs in a byte; u8, [y][x][d]) -> left_map, right_map (i16)
//   The leftward direction of sgm_aggregate is walked here, so its T is never stored. PAIRED volumes hold two
//   directions each, `forward` holds the rightward one.
// One invocation: one row of the band, from right to left.
// Reference: src/reference/winner.rs, src/reference/sgm_aggregate.rs

@group(0) @binding(2) var<storage, read> cost: array<vec4<u32>>;
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
    var state: array<u32, WORDS>;
    var costs: array<vec4<u32>, WORDS>;
    var diagonal: array<vec4<u32>, WORDS>;
    for (var q = 0u; q < QUADS; q++) {
        for (var i = 0u; i < 4u; i++) {
            diagonal[4u * q + i] = vec4(0xffffffffu);
        }
    }
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
fn walk(state: ptr<function, array<u32, WORDS>>, costs: ptr<function, array<vec4<u32>, WORDS>>, at: u32) {
    let least = path_minimum(state);
    var below = NONE;
    var here = unpack((*state)[0]);
    for (var q = 0u; q < QUADS; q++) {
        let c = cost[at + q];
        let t0 = forward[at + q];
        let t1 = paired0[at + q];
        var t2 = vec4(0u);
        var t3 = vec4(0u);
        if PAIRED == 3u {
            t2 = paired1[at + q];
            t3 = paired2[at + q];
        }
        for (var i = 0u; i < 4u; i++) {
            let k = 4u * q + i;
            var next = vec4(NONE);
            if k + 1u < WORDS {
                next = unpack((*state)[min(k + 1u, WORDS - 1u)]);
            }
            let t = smoothness(here, below, next.x, least);
            (*state)[k] = t + c[i];
            (*costs)[k] = unpack_pairs(PATHS * bytes_to_pairs(c[i]) + bytes_to_pairs(t) + bytes_to_pairs(t0[i])
                + bytes_to_pairs(t1[i]) + bytes_to_pairs(t2[i]) + bytes_to_pairs(t3[i]));
            below = here.w;
            here = next;
        }
    }
    path_close(state);
}
