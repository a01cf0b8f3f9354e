// Appended to the kernels that walk paths or rows: MEMBERS neighbouring invocations, its members, share a path. Each owns
// OWN_QUADS vectors of 16 of a pixel's disparities. A fragment shared_path_* says how they exchange values.

// Above every value that is compared, with room for a penalty.
const NONE: u32 = 0xffffff00u;

// Above every value of 15 bits, with room for penalties of many steps.
const FAR: u32 = 0xffffu;

// Of the disparities of all members: the smallest value, and the values next to a member's own, NONE at the ends.
struct Surroundings {
    least: u32,
    below: u32,
    above: u32,
}

// The number of the member that is at a place of the group, and the other way round.
fn member_of(local: u32) -> u32 {
    return select(local % MEMBERS, MEMBERS - 1u - local % MEMBERS, BACKWARDS);
}

// Where a member's slice s of a pixel lies in a volume.
fn slice_at(pixel: u32, s: u32) -> u32 {
    return (pixel * QUADS + member * OWN_QUADS) / WIDTH + s;
}

// Whether a member's vector of 16 disparities lies in the volume.
fn in_volume(own: u32) -> bool {
    return MEMBERS * OWN_QUADS == QUADS || member * OWN_QUADS + own < QUADS;
}

// The bytes of a member's vector that lie beyond the range of disparities.
fn beyond(own: u32) -> vec4<u32> {
    let quad = member * OWN_QUADS + own;
    let of_last = select(vec4(0u), BEYOND, quad + 1u == QUADS);
    return select(of_last, vec4(0xffffffffu), MEMBERS * OWN_QUADS > QUADS && quad >= QUADS);
}
