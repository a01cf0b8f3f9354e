// coarse_cost_sums: as coarse_cost, for the levels after that, from the one before.
// terms (u16, [y][x][d], two a word: of four disparities the even ones, then the odd ones) -> sums, laid out alike
// MEMBERS invocations: a pixel.
// Border: what lies outside the image counts nothing.
// With: sum_terms, data_coarse, pairs, common
// Chosen: shared_path*, volume*
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
