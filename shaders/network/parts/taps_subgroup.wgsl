// Appended to the convolutions where subgroups have eight invocations or more: the weights of a line of taps, each loaded by one of
// eight neighbours and given to the others. WGSL does not promise that a subgroup numbers the invocations of a workgroup in
// the workgroup's order. Devices do, and --check would report one that does not.

fn taps_at(at: u32, lane: u32) -> Taps {
    let own = min(lane, 4u * SIDE - 1u);
    let first = weight_at(at + own);
    var taps = Taps();
    taps[0] = subgroupBroadcast(first, 0u);
    taps[1] = subgroupBroadcast(first, 1u);
    taps[2] = subgroupBroadcast(first, 2u);
    taps[3] = subgroupBroadcast(first, 3u);
    if SIDE > 1u {
        let second = weight_at(at + 8u + min(lane, 3u));
        taps[4] = subgroupBroadcast(first, 4u);
        taps[5] = subgroupBroadcast(first, 5u);
        taps[6] = subgroupBroadcast(first, 6u);
        taps[7] = subgroupBroadcast(first, 7u);
        taps[8] = subgroupBroadcast(second, 0u);
        taps[9] = subgroupBroadcast(second, 1u);
        taps[10] = subgroupBroadcast(second, 2u);
        taps[11] = subgroupBroadcast(second, 3u);
    }
    return taps;
}
