// Appended to the kernels that compare pixels: |l - r|; of two planes their sum, of three colours an average of them.
fn pixel_costs(left: Pixel, right: Window) -> vec4<u32> {
    var l = left;
    var r = right;
    var costs: Window;
    for (var p = 0u; p < PLANES; p++) {
        costs[p] = differences(vec4(l[p]), r[p]);
    }
    if PLANES == 3u {
        return byte_means(byte_means(costs[0], costs[PLANES - 1u]), costs[1u % PLANES]);
    }
    if PLANES == 2u {
        return costs[0] + costs[PLANES - 1u];
    }
    return costs[0];
}
