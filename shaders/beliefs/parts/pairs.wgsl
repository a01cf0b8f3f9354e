// Appended to the kernels that add up data terms and messages: sixteen values of 16 bits, two a word.

struct Pairs {
    even: vec4<u32>,
    odd: vec4<u32>,
}

// Of a slice.
alias Data = array<Pairs, WIDTH>;

// Sixteen bytes.
fn pairs_of(bytes: vec4<u32>) -> Pairs {
    return Pairs(bytes & vec4(0xff00ffu), (bytes >> vec4(8u)) & vec4(0xff00ffu));
}

fn sum_of(a: Pairs, b: Pairs) -> Pairs {
    return Pairs(a.even + b.even, a.odd + b.odd);
}
