// Appended with shared_path where the members of a path are neighbours in a subgroup and exchange values by shuffles.
// WGSL does not promise that a subgroup numbers the invocations of a one-dimensional workgroup in the workgroup's order.
// Devices do, and --check would report one that does not.
const BARRIERS: bool = false;
var<private> member: u32;

// The group that an invocation belongs to.
fn join_group(invocation: u32, local: u32) -> u32 {
    member = member_of(local);
    return invocation / MEMBERS;
}

fn exchange(least: u32, first: u32, last: u32) -> Surroundings {
    var least_of_all = least;
    for (var bit = 0u; bit < MEMBER_BITS; bit++) {
        least_of_all = min(least_of_all, subgroupShuffleXor(least_of_all, 1u << bit));
    }
    let below = select(subgroupShuffleUp(last, 1u), subgroupShuffleDown(last, 1u), BACKWARDS);
    let above = select(subgroupShuffleDown(first, 1u), subgroupShuffleUp(first, 1u), BACKWARDS);
    return Surroundings(least_of_all, select(below, NONE, member == 0u), select(above, NONE, member + 1u == MEMBERS));
}

// Of all members: the sums of x and of y, the smallest z.
fn neighbours_and_rival(own: vec3<u32>) -> vec3<u32> {
    var all = own;
    for (var bit = 0u; bit < MEMBER_BITS; bit++) {
        let other = subgroupShuffleXor(all, 1u << bit);
        all = vec3(all.xy + other.xy, min(all.z, other.z));
    }
    return all;
}

// What the values at the ends of other members are, seen from a member's own ends, if each member between them adds `step`: the
// smallest of the last values of those below, and of the first values of those above.
fn beside(first: u32, last: u32, step: u32) -> vec2<u32> {
    var below = last;
    var above = first;
    for (var bit = 0u; bit < MEMBER_BITS; bit++) {
        let far = 1u << bit;
        let lower = select(subgroupShuffleUp(below, far), subgroupShuffleDown(below, far), BACKWARDS);
        let upper = select(subgroupShuffleDown(above, far), subgroupShuffleUp(above, far), BACKWARDS);
        below = min(below, select(FAR, lower + far * step, member >= far));
        above = min(above, select(FAR, upper + far * step, member + far < MEMBERS));
    }
    let lower = select(subgroupShuffleUp(below, 1u), subgroupShuffleDown(below, 1u), BACKWARDS);
    let upper = select(subgroupShuffleDown(above, 1u), subgroupShuffleUp(above, 1u), BACKWARDS);
    return vec2(select(lower, FAR, member == 0u), select(upper, FAR, member + 1u == MEMBERS));
}
