// coarse_cost: the data terms of the second level: the sums of the costs of 2 x 2 pixels, less the smallest of a pixel.
// cost (u8, [y][x][d]) -> sums (u16, [y][x][d], two a word: of four disparities the even ones, then the odd ones)
// MEMBERS invocations: a pixel.
// Border: what lies outside the image counts nothing.
// With: sum_terms, data_cost, pairs, common
// Chosen: shared_path*, volume*, cost_*
// Reference: src/reference/beliefs/coarse_cost.rs

const BACKWARDS: bool = false;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let x = join_group(id.x, local);
    let works = x < dispatch.lines;
    // src/gpu/kernels/source.rs takes this out where barriers follow.
    if !works {
        return;
    }
    sum_terms(min(x, dispatch.lines - 1u), id.y, works || !BARRIERS);
}
