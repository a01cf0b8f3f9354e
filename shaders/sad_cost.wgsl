// sad_cost: (sum of 2 r + 1 neighbouring columns * cost_scale + 2^23) >> 24, from 0 to 89.
// columns (u16, [y][x + r][d]) -> cost (u8, [y][x][d], four disparities a word)
// One invocation: one row of the band, from left to right; a column enters the sum as another leaves it.
// Border: the columns reach beyond it. Disparities beyond the range are computed like the others and never used.
// Reference: src/reference/sad_cost.rs

@group(0) @binding(2) var<storage, read> columns: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> cost: array<vec4<u32>>;

fn quantised(sums: vec4<u32>) -> u32 {
    return pack((sums * frame.cost_scale + vec4(1u << 23u)) >> vec4(24u));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = id.x;
    if row >= pass_.rows {
        return;
    }
    let reach = 2u * frame.block_radius;
    let first = row * (frame.width + reach) * 2u * QUADS;
    var sums: array<vec4<u32>, WORDS>;
    for (var c = 0u; c < reach; c++) {
        for (var q = 0u; q < 2u * QUADS; q++) {
            let entering = columns[first + c * 2u * QUADS + q];
            sums[2u * q] += unpack_pairs(entering.xy);
            sums[2u * q + 1u] += unpack_pairs(entering.zw);
        }
    }
    for (var x = 0u; x < frame.width; x++) {
        let leaves = first + x * 2u * QUADS;
        let enters = leaves + reach * 2u * QUADS;
        let at = ((pass_.volume_row + row) * frame.width + x) * QUADS;
        for (var q = 0u; q < QUADS; q++) {
            let in0 = columns[enters + 2u * q];
            let in1 = columns[enters + 2u * q + 1u];
            let out0 = columns[leaves + 2u * q];
            let out1 = columns[leaves + 2u * q + 1u];
            let s0 = sums[4u * q] + unpack_pairs(in0.xy);
            let s1 = sums[4u * q + 1u] + unpack_pairs(in0.zw);
            let s2 = sums[4u * q + 2u] + unpack_pairs(in1.xy);
            let s3 = sums[4u * q + 3u] + unpack_pairs(in1.zw);
            cost[at + q] = vec4(quantised(s0), quantised(s1), quantised(s2), quantised(s3));
            sums[4u * q] = s0 - unpack_pairs(out0.xy);
            sums[4u * q + 1u] = s1 - unpack_pairs(out0.zw);
            sums[4u * q + 2u] = s2 - unpack_pairs(out1.xy);
            sums[4u * q + 3u] = s3 - unpack_pairs(out1.zw);
        }
    }
}
