// feature_convolution: a layer that sums over 3x3 pixels in all channels, but the first one (feature_input).
// values (bytes, [block of four channels][row][vector]), weights -> result, laid out alike, or of 16 bits
// One invocation: 8 GROUPS channels of four columns of a row. A step of the weights: three columns of a row of a block of inputs.
// Border: rows and columns are clamped into the image.
// With: groups, neighbours, layer, common
// Chosen: products_*, texels_*
// Reference: src/reference/features/feature_layer.rs

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let place = place_of(id.x);
    let group = id.y * GROUPS;
    let lane = local % 8u;
    let steps = 3u * dispatch.own.in_blocks;
    var sums = begun(group, steps, lane);
    for (var step = 0u; step < steps; step++) {
        let texels = texels_at(group, steps, step + 1u, lane);
        let columns = six_columns(step / 3u, row_below(place.row, step % 3u), place.vector);
        add(vec4(columns[0], columns[1], columns[2], columns[3]), 0u, texels, &sums);
        add(vec4(columns[1], columns[2], columns[3], columns[4]), 1u, texels, &sums);
        add(vec4(columns[2], columns[3], columns[4], columns[5]), 2u, texels, &sums);
    }
    leave_sums(place, group, steps, lane, sums);
}
