// Appended to the kernels that match blocks: the cost of a block is its sum, narrowed.

// What is known of the right blocks: nothing.
alias Seen = u32;

fn none_seen(row: u32) -> Seen {
    return 0u;
}

fn block_costs(costs: ptr<function, Costs>, sums: ptr<function, Costs>, seen: ptr<function, Seen>, row: u32, x: i32) {
    for (var q = 0u; q < OWN_QUADS; q++) {
        for (var i = 0u; i < 4u; i++) {
            (*costs)[q][i] = (*sums)[q][i] >> vec4(NARROWING);
        }
    }
}
