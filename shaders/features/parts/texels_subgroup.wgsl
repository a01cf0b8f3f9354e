// Appended to the layers where subgroups have eight invocations or more: eight texels of weights, each loaded by one of eight
// neighbours and given to the others. WGSL does not promise that a subgroup numbers the invocations of a workgroup in the
// workgroup's order. Devices do, and --check would report one that does not.

fn eight_texels(at: u32, lane: u32) -> array<vec4<u32>, 8> {
    let own = weights[at + lane];
    return array(subgroupBroadcast(own, 0u), subgroupBroadcast(own, 1u), subgroupBroadcast(own, 2u),
        subgroupBroadcast(own, 3u), subgroupBroadcast(own, 4u), subgroupBroadcast(own, 5u), subgroupBroadcast(own, 6u),
        subgroupBroadcast(own, 7u));
}
