// Appended to the kernels that read or write volumes, where a load or store moves 16 disparities.
alias Stored = vec4<u32>;
alias Slice = array<vec4<u32>, 1>;

fn slice_of(stored: Stored) -> Slice {
    return Slice(stored);
}

fn stored_of(slice: Slice) -> Stored {
    return slice[0];
}

fn stored_terms(terms: Slice) -> Stored {
    return min(stored_of(terms), vec4(0xfefefefeu)); // as in volume32.wgsl
}

fn stored_messages(messages: Slice) -> Stored {
    return min(stored_of(messages), vec4(~frame.width)); // as in volume32.wgsl
}
