// feature_point: a layer that sums over the channels of a pixel.
// values (bytes, [block of four channels][row][vector]), weights -> result, laid out alike, or of 16 bits
// One invocation: 8 GROUPS channels of four columns of a row. A step of the weights: four blocks of inputs.
// Border: columns beyond it repeat it.
// With: groups, layer, common
// Chosen: products_*, texels_*
// Reference: src/reference/features/feature_layer.rs

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let place = place_of(id.x);
    let group = id.y * GROUPS;
    let lane = local % 8u;
    let steps = (dispatch.own.in_blocks + 3u) / 4u;
    let row = dispatch.first_row + place.row - dispatch.own.in_first;
    let at = row * row_vectors() + place.vector;
    let stride = dispatch.own.in_rows * row_vectors();
    var sums = begun(group, steps, lane);
    for (var step = 0u; step < steps; step++) {
        let texels = texels_at(group, steps, step + 1u, lane);
        for (var k = 0u; k < 4u; k++) {
            // Blocks beyond the last one have weights of 0.
            let block = min(4u * step + k, dispatch.own.in_blocks - 1u);
            add(values[block * stride + at], k, texels, &sums);
        }
    }
    leave_sums(place, group, steps, lane, sums);
}
