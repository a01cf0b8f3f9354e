// Appended to the kernels that sum products of bytes with signs: four at once, for which GPUs have an instruction.
alias Sum = i32;
alias Four = u32;

fn four_of(word: u32) -> Four {
    return word;
}

fn plus_products(sum: Sum, a: Four, b: Four) -> Sum {
    return sum + dot4I8Packed(a, b);
}
