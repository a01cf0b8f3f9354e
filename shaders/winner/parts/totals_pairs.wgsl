// Appended to the kernels that choose among costs below 2^16 - 1: what the disparities of a pixel cost, two a word.
const COST_NONE: u32 = 0xffffu;

alias Totals = array<Pairs, OWN_QUADS>;

fn no_totals() -> Totals {
    var totals: Totals;
    for (var q = 0u; q < OWN_QUADS; q++) {
        totals[q] = Pairs(vec4(0xffffffffu), vec4(0xffffffffu));
    }
    return totals;
}

// Disparities beyond the range cost COST_NONE.
fn hide_beyond(totals: ptr<function, Totals>) {
    for (var q = 0u; q < OWN_QUADS; q++) {
        let outside = pairs_of(beyond(q));
        (*totals)[q].even |= outside.even * 0x101u;
        (*totals)[q].odd |= outside.odd * 0x101u;
    }
}

// Of the four disparities from 4 i on.
fn totals_at(totals: ptr<function, Totals>, q: u32, i: u32) -> vec4<u32> {
    return unpack_pairs((*totals)[q].even[i], (*totals)[q].odd[i]);
}

// Of disparity d of sixteen, found by its bits: an index that is no constant would keep all in memory.
fn total_of(totals: ptr<function, Totals>, q: u32, d: u32) -> u32 {
    let four = select((*totals)[q].even, (*totals)[q].odd, vec4((d & 1u) != 0u));
    let two = select(four.xy, four.zw, vec2((d & 8u) != 0u));
    let word = select(two.x, two.y, (d & 4u) != 0u);
    return select(word & 0xffffu, word >> 16u, (d & 2u) != 0u);
}
