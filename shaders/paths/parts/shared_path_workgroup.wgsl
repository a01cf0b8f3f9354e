// Appended with shared_path where the members of a path exchange values through workgroup memory. Two sets of places take
// turns: once a barrier is passed, every invocation has read the other set. Every invocation of a workgroup must call
// `deposit` equally often.
const BARRIERS: bool = true;
var<workgroup> places: array<vec3<u32>, 2u * LANES>;
var<private> member: u32;
var<private> lane: u32;
var<private> turn: u32;

// The group that an invocation belongs to.
fn join_group(invocation: u32, local: u32) -> u32 {
    lane = local;
    member = member_of(local);
    return invocation / MEMBERS;
}

// Deposits a member's values and waits for the others'. Returns the first place of the group.
fn deposit(values: vec3<u32>) -> u32 {
    turn = LANES - turn;
    places[turn + lane] = values;
    workgroupBarrier();
    return turn + lane - lane % MEMBERS;
}

fn exchange(least: u32, first: u32, last: u32) -> Surroundings {
    let start = deposit(vec3(least, first, last));
    var around = Surroundings(least, NONE, NONE);
    for (var i = 0u; i < MEMBERS; i++) {
        around.least = min(around.least, places[start + i].x);
    }
    if member > 0u {
        around.below = places[start + member_of(member - 1u)].z;
    }
    if member + 1u < MEMBERS {
        around.above = places[start + member_of(member + 1u)].y;
    }
    return around;
}

// Of all members: the sums of x and of y, the smallest z.
fn neighbours_and_rival(own: vec3<u32>) -> vec3<u32> {
    let start = deposit(own);
    var all = vec3(0u, 0u, NONE);
    for (var i = 0u; i < MEMBERS; i++) {
        let other = places[start + i];
        all = vec3(all.xy + other.xy, min(all.z, other.z));
    }
    return all;
}

// As in shared_path_subgroup.wgsl.
fn beside(first: u32, last: u32, step: u32) -> vec2<u32> {
    let start = deposit(vec3(first, last, 0u));
    var below = FAR;
    var above = FAR;
    for (var i = 0u; i < MEMBERS; i++) {
        let other = member_of(i);
        let ends = places[start + i];
        if other < member {
            below = min(below, ends.y + (member - 1u - other) * step);
        }
        if other > member {
            above = min(above, ends.x + (other - 1u - member) * step);
        }
    }
    return vec2(below, above);
}
