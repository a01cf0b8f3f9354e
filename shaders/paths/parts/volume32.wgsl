// Appended to the kernels that read or write volumes, where a load or store moves 32 disparities as 64-bit integers.
alias Stored = vec4<u64>;
alias Slice = array<vec4<u32>, 2>;

fn slice_of(stored: Stored) -> Slice {
    let low = vec4<u32>(stored);
    let high = vec4<u32>(stored >> vec4(32u));
    return Slice(vec4(low.x, high.x, low.y, high.y), vec4(low.z, high.z, low.w, high.w));
}

fn stored_of(slice: Slice) -> Stored {
    let low = vec4<u64>(vec4(slice[0].xz, slice[1].xz));
    let high = vec4<u64>(vec4(slice[0].yw, slice[1].yw));
    return low | (high << vec4(32u));
}

// Of bytes up to 254: the minimum changes nothing, but keeps LLVM from moving the arithmetic before it into lavapipe's
// store, which is a loop over the lanes (docs/PERFORMANCE.md).
fn stored_terms(terms: Slice) -> Stored {
    return min(stored_of(terms), vec4(0xfefefefefefefefelu));
}

// Of bytes up to 127, which LLVM knows: only a bound that it does not know keeps it from moving the arithmetic.
fn stored_messages(messages: Slice) -> Stored {
    return min(stored_of(messages), ~vec4(u64(frame.width)));
}
