// Appended to the kernels that make the data terms of a level: the sums over 2 x 2 pixels, less the smallest of a pixel.
// Reference: src/reference/beliefs/coarse_cost.rs

struct Own {
    width: u32,         // of the finer images
    rows: u32,          // of the band in them
    stride: u32,        // pixels a row of their volumes
    coarse_stride: u32, // the same of the sums
}

@group(0) @binding(3) var<storage, read_write> sums: array<vec4<u32>>;

fn sum_terms(x: u32, row: u32, writes: bool) {
    var totals: array<Pairs, OWN_QUADS>;
    for (var k = 0u; k < 4u; k++) {
        let column = 2u * x + (k & 1u);
        let line = 2u * row + (k >> 1u);
        if column < dispatch.own.width && line < dispatch.own.rows {
            for (var s = 0u; s < SLICES; s++) {
                if in_volume(s * WIDTH) {
                    let data = data_at(slice_at(line * dispatch.own.stride + column, s));
                    for (var w = 0u; w < WIDTH; w++) {
                        totals[s * WIDTH + w] = sum_of(totals[s * WIDTH + w], data[w]);
                    }
                }
            }
        }
    }
    var least = vec4(NONE);
    for (var q = 0u; q < OWN_QUADS; q++) {
        for (var i = 0u; i < 4u; i++) {
            let sums = unpack_pairs(totals[q].even[i], totals[q].odd[i]);
            least = min(least, select(sums, vec4(NONE), unpack(beyond(q)[i]) != vec4(0u)));
        }
    }
    let smallest = exchange(lowest(least), 0u, 0u).least;
    if !writes {
        return;
    }
    for (var s = 0u; s < SLICES; s++) {
        if in_volume(s * WIDTH) {
            let slice = slice_at(row * dispatch.own.coarse_stride + x, s);
            for (var w = 0u; w < WIDTH; w++) {
                let q = s * WIDTH + w;
                for (var i = 0u; i < 2u; i++) {
                    // What is beyond the range of disparities may wrap; nobody reads it.
                    let first = unpack_pairs(totals[q].even[2u * i], totals[q].odd[2u * i]);
                    let second = unpack_pairs(totals[q].even[2u * i + 1u], totals[q].odd[2u * i + 1u]);
                    let a = min(first - vec4(smallest), vec4(LARGEST_TERM));
                    let b = min(second - vec4(smallest), vec4(LARGEST_TERM));
                    sums[2u * (slice * WIDTH + w) + i] = vec4(a.xy | (a.zw << vec2(16u)), b.xy | (b.zw << vec2(16u)));
                }
            }
        }
    }
}
