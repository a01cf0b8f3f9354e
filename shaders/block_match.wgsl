// block_match: the disparity of the smallest block sum; the right view likewise.
// columns (u16, [y][x + r][d]) -> left_map, right_map (i16)
// One invocation: one row of the band, from right to left; a column enters the sum as another leaves it.
// Border: the columns reach beyond it.
// Reference: src/reference/block_match.rs

@group(0) @binding(2) var<storage, read> columns: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> left_map: array<u32>;
@group(0) @binding(4) var<storage, read_write> right_map: array<u32>;

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= pass_.rows {
        return;
    }
    let row = pass_.first_row + id.x;
    let reach = 2u * frame.block_radius;
    let first = id.x * (frame.width + reach) * 2u * QUADS;
    var sums: array<vec4<u32>, WORDS>;
    var costs: array<vec4<u32>, WORDS>;
    var diagonal: array<vec4<u32>, WORDS>;
    for (var q = 0u; q < QUADS; q++) {
        for (var i = 0u; i < 4u; i++) {
            diagonal[4u * q + i] = vec4(0xffffffffu);
        }
    }
    for (var c = 0u; c < reach; c++) {
        for (var q = 0u; q < QUADS; q++) {
            let at = first + (frame.width + c) * 2u * QUADS + 2u * q;
            let entering0 = columns[at];
            let entering1 = columns[at + 1u];
            sums[4u * q] += unpack_pairs(entering0.xy);
            sums[4u * q + 1u] += unpack_pairs(entering0.zw);
            sums[4u * q + 2u] += unpack_pairs(entering1.xy);
            sums[4u * q + 3u] += unpack_pairs(entering1.zw);
        }
    }
    var kept = RowWriter(INVALID, INVALID);
    let steps = row_steps();
    for (var i = 0; i < steps; i++) {
        let x = row_start() - i;
        if inside_row(x) {
            let enters = first + u32(x) * 2u * QUADS;
            let leaves = enters + reach * 2u * QUADS;
            for (var q = 0u; q < QUADS; q++) {
                let in0 = columns[enters + 2u * q];
                let in1 = columns[enters + 2u * q + 1u];
                let out0 = columns[leaves + 2u * q];
                let out1 = columns[leaves + 2u * q + 1u];
                let s0 = sums[4u * q] + unpack_pairs(in0.xy);
                let s1 = sums[4u * q + 1u] + unpack_pairs(in0.zw);
                let s2 = sums[4u * q + 2u] + unpack_pairs(in1.xy);
                let s3 = sums[4u * q + 3u] + unpack_pairs(in1.zw);
                costs[4u * q] = s0;
                costs[4u * q + 1u] = s1;
                costs[4u * q + 2u] = s2;
                costs[4u * q + 3u] = s3;
                sums[4u * q] = s0 - unpack_pairs(out0.xy);
                sums[4u * q + 1u] = s1 - unpack_pairs(out0.zw);
                sums[4u * q + 2u] = s2 - unpack_pairs(out1.xy);
                sums[4u * q + 3u] = s3 - unpack_pairs(out1.zw);
            }
        }
        choose(&costs, &diagonal, &kept, row, x);
    }
}
