// Appended to the kernels that walk the last path, leftwards along a row, and add up all: T of all directions but this one, of each
// pixel and sixteen disparities. PAIRED volumes hold two directions each, the i-th in buffer i % 3; `forward` holds the rightward one.

// A row is walked backwards, and so is a pixel by its members: then all addresses descend, which CPUs prefetch.
const BACKWARDS: bool = true;

@group(0) @binding(3) var<storage, read> forward: array<Stored>;
@group(0) @binding(5) var<storage, read> paired1: array<Stored>;
@group(0) @binding(6) var<storage, read> paired2: array<Stored>;

alias Terms = array<Slice, PAIRED + 1u>;

fn terms_of(pixel: u32, strip_pixel: u32, s: u32) -> Terms {
    var t: Terms;
    t[0] = slice_of(forward[slice_at(strip_pixel, s)]);
    t[1] = slice_of(paired0[slice_at(pixel, s)]);
    for (var i = 1u; i < PAIRED; i++) {
        let at = slice_at(pixel + i / 3u * dispatch.slot, s);
        switch i % 3u {
            case 0u: { t[i + 1u] = slice_of(paired0[at]); }
            case 1u: { t[i + 1u] = slice_of(paired1[at]); }
            default: { t[i + 1u] = slice_of(paired2[at]); }
        }
    }
    return t;
}

// `first` and the T of all directions, of which `own` are those of the step.
fn sum_of_terms(first: Pairs, own: vec4<u32>, t: ptr<function, Terms>, w: u32) -> Pairs {
    // Of this direction and the opposite one: both T are at most 127.
    var sums = sum_of(first, pairs_of(own + (*t)[0][w]));
    for (var i = 1u; i < PAIRED + 1u; i++) {
        sums = sum_of(sums, pairs_of((*t)[i][w]));
    }
    return sums;
}
