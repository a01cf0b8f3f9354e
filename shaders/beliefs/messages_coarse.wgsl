// messages_coarse: as messages, at a level of sums of costs.
// terms (u16, [y][x][d], two a word: of four disparities the even ones, then the odd ones), what others sent -> messages
// MEMBERS invocations: a pixel.
// Border: as in messages.
// With: send, received, data_coarse, edges_fixed, pairs, costs, common
// Chosen: shared_path*, volume*, smoothness_*
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
