// Appended to the convolutions: the weights of a line of taps, each loaded by every invocation.

fn taps_at(at: u32, lane: u32) -> Taps {
    var taps = Taps();
    for (var i = 0u; i < 4u * SIDE; i++) {
        taps[i] = weight_at(at + i);
    }
    return taps;
}
