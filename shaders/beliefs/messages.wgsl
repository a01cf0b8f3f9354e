// messages: what pixels of one colour of a chessboard send to their four neighbours, which are of the other colour.
// cost (u8, [y][x][d]), what others sent -> messages (u8, four volumes [y][x][d]: up, down, left, right)
//   above, below: the messages of the bands next to this one.
// MEMBERS invocations: a pixel. They read what pixels of the other colour sent and write what theirs sends: in place.
// Border: nothing is sent beyond the image, and nothing comes from there.
// With: send, received, data_cost, pairs, costs, common
// Chosen: shared_path*, volume*, cost_*, smoothness_*, edges_*
// Reference: src/reference/beliefs/messages.rs

const BACKWARDS: bool = false;

@group(0) @binding(3) var<storage, read_write> messages: array<Stored>;
@group(0) @binding(4) var<storage, read> above: array<Stored>;
@group(0) @binding(5) var<storage, read> below: array<Stored>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let x = 2u * join_group(id.x, local) + ((dispatch.own.odd + dispatch.own.first + id.y) & 1u);
    let works = x < dispatch.own.width;
    // src/gpu/kernels/source.rs takes this out where barriers follow.
    if !works {
        return;
    }
    send(min(x, dispatch.own.width - 1u), id.y, works || !BARRIERS);
}
