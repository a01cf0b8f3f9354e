// Appended to the kernels that choose among costs of up to 20 bits: what the disparities of a pixel cost, a word each.
const COST_NONE: u32 = 0xfffffu;

alias Totals = Costs;

fn no_totals() -> Totals {
    var totals: Totals;
    for (var q = 0u; q < OWN_QUADS; q++) {
        totals[q] = array(vec4(COST_NONE), vec4(COST_NONE), vec4(COST_NONE), vec4(COST_NONE));
    }
    return totals;
}

// Disparities beyond the range cost COST_NONE.
fn hide_beyond(totals: ptr<function, Totals>) {
    for (var q = 0u; q < OWN_QUADS; q++) {
        for (var i = 0u; i < 4u; i++) {
            let outside = unpack(beyond(q)[i]) != vec4(0u);
            (*totals)[q][i] = select((*totals)[q][i], vec4(COST_NONE), outside);
        }
    }
}

// Of the four disparities from 4 i on.
fn totals_at(totals: ptr<function, Totals>, q: u32, i: u32) -> vec4<u32> {
    return (*totals)[q][i];
}

// Of disparity d of sixteen, found by its bits: an index that is no constant would keep all in memory.
fn total_of(totals: ptr<function, Totals>, q: u32, d: u32) -> u32 {
    let high = vec4((d & 4u) != 0u);
    let lower = select((*totals)[q][0], (*totals)[q][1], high);
    let upper = select((*totals)[q][2], (*totals)[q][3], high);
    let four = select(lower, upper, vec4((d & 8u) != 0u));
    let two = select(four.xy, four.zw, vec2((d & 2u) != 0u));
    return select(two.x, two.y, (d & 1u) != 0u);
}
