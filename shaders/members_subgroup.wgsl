// Appended to the kernels whose disparities members share: neighbours in a subgroup, which hand values to each other.
const BARRIERS: bool = false;
var<private> member: u32;

// The group that an invocation belongs to.
fn join_group(invocation: u32, local: u32) -> u32 {
    member = local % MEMBERS;
    return invocation / MEMBERS;
}

fn exchange(least: u32, first: u32, last: u32) -> Surroundings {
    var least_of_all = least;
    for (var step = 1u; step < MEMBERS; step *= 2u) {
        least_of_all = min(least_of_all, subgroupShuffleXor(least_of_all, step));
    }
    let below = subgroupShuffleUp(last, 1u);
    let above = subgroupShuffleDown(first, 1u);
    return Surroundings(least_of_all, select(below, NONE, member == 0u), select(above, NONE, member + 1u == MEMBERS));
}

fn sum_of_members(own: vec3<u32>) -> vec3<u32> {
    var sum = own;
    for (var step = 1u; step < MEMBERS; step *= 2u) {
        sum += subgroupShuffleXor(sum, step);
    }
    return sum;
}
