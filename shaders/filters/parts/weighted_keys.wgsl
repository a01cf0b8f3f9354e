// Appended to the kernels of the weighted median: 25 keys, each a value above its weight, and their median.

// Values lie above invalid, which is 0.
const NOTHING: u32 = 0x80008000u;

// Orders the keys i and i + distance, of those i that have `bit` as in `wanted`.
fn exchange(keys: ptr<function, array<u32, 25>>, bit: u32, wanted: u32, distance: u32) {
    for (var i = 0u; i < 25u; i++) {
        if i + distance < 25u && (i & bit) == wanted {
            let a = (*keys)[i];
            let b = (*keys)[i + distance];
            (*keys)[i] = min(a, b);
            (*keys)[i + distance] = max(a, b);
        }
    }
}

// Merge exchange: Knuth, The Art of Computer Programming 3, algorithm 5.2.2M.
fn sort(keys: ptr<function, array<u32, 25>>) {
    exchange(keys, 16u, 0u, 16u);
    exchange(keys, 8u, 0u, 8u);
    exchange(keys, 8u, 8u, 8u);
    exchange(keys, 4u, 0u, 4u);
    exchange(keys, 4u, 4u, 12u);
    exchange(keys, 4u, 4u, 4u);
    exchange(keys, 2u, 0u, 2u);
    exchange(keys, 2u, 2u, 14u);
    exchange(keys, 2u, 2u, 6u);
    exchange(keys, 2u, 2u, 2u);
    exchange(keys, 1u, 0u, 1u);
    exchange(keys, 1u, 1u, 15u);
    exchange(keys, 1u, 1u, 7u);
    exchange(keys, 1u, 1u, 3u);
    exchange(keys, 1u, 1u, 1u);
}

// Of keys in ascending order, a value above its weight: the first value at which half of all weight is reached.
fn middle(keys: ptr<function, array<u32, 25>>) -> u32 {
    var total = 0u;
    for (var i = 0u; i < 25u; i++) {
        total += (*keys)[i] & 0xffffu;
    }
    var reached = total;
    var value = 0u;
    for (var i = 0u; i < 25u; i++) {
        let key = (*keys)[24u - i];
        value = select(value, key >> 16u, 2u * reached >= total);
        reached -= key & 0xffffu;
    }
    return value;
}
