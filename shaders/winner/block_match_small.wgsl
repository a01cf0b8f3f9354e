// block_match_small: block_match for blocks of up to 15 pixels and values below 128, without column sums in memory.
// left, right (prefiltered planes as textures, four pixels a texel) -> left_map, right_map (i16), labels (u16, behind right_map)
// One invocation: STRIP rows and one slice of the disparities, from right to left; PARTS neighbours of a subgroup share
//   the rows. The right pixels that the disparities are compared with stay in registers and move down by one disparity
//   a step: those of the column that enters the block, and those of the column that leaves it.
// Border: rows are clamped into the image, columns by the planes.
// With: refinement, common
// Reference: src/reference/winner/block_match.rs

@group(0) @binding(2) var left: texture_storage_2d<r32uint, read>;
@group(0) @binding(3) var right: texture_storage_2d<r32uint, read>;
@group(0) @binding(4) var<storage, read_write> left_map: array<u32>;
@group(0) @binding(5) var<storage, read_write> right_map: array<u32>;

// Disparity d of a slice is byte d / QUARTER of word d % QUARTER of a window, and half d / HALF of pair d % HALF: so a
// step of one disparity is a step of one word.
const QUARTER: u32 = (DISPARITIES + 4u * PARTS - 1u) / (4u * PARTS);
const HALF: u32 = 2u * QUARTER;
const SLICE: u32 = 4u * QUARTER;
const PADDED: bool = SLICE * PARTS != DISPARITIES;

// Rows that the blocks of a strip span.
const ROWS: u32 = STRIP + BLOCK - 1u;

// Rows of the maps that an invocation completes.
const OWN: u32 = STRIP / PARTS;

// Block sums are at most 15 * 15 * 127 < 2^15. A candidate is the key sum << 16 | d: the smallest key is the smallest
// sum, and of those the smallest disparity; by the rules of StereoBM the largest one of the left view, whose bits REVERSED
// turns. Disparities beyond the range, and pixels beyond the row, have SUM_NONE.
const SUM_NONE: u32 = 0x7fffu;
const KEY_NONE: u32 = 0x7fff0000u;
const REVERSED: u32 = 0xffffu * STEREO_BM;
const TOP_BITS: u32 = 0x80808080u;
const EVEN_BYTES: u32 = 0xff00ffu;

alias Words = array<u32, ROWS>;
alias Windows = array<array<u32, QUARTER>, ROWS>;
alias Pairs = array<array<u32, HALF>, STRIP>;

// Pixels of OWN rows that are not yet written, two a word, the leftmost one in the low half of [0].
alias Unwritten = array<array<u32, 3>, OWN>;

// Of the planes.
fn row_at(top: i32, row: u32) -> u32 {
    return u32(clamp(top + i32(row), 0, i32(frame.height) - 1)) - dispatch.planes_row;
}

// The four bytes from byte `at` of a row on.
fn left_bytes(at: i32, row: u32) -> u32 {
    let last = i32(frame.left_stride) - 1;
    let low = textureLoad(left, vec2(u32(clamp(at >> 2u, 0, last)), row)).x;
    let high = textureLoad(left, vec2(u32(clamp((at >> 2u) + 1, 0, last)), row)).x;
    return bytes_between(low, high, at);
}

fn right_bytes(at: i32, row: u32) -> u32 {
    let last = i32(frame.right_stride) - 1;
    let low = textureLoad(right, vec2(u32(clamp(at >> 2u, 0, last)), row)).x;
    let high = textureLoad(right, vec2(u32(clamp((at >> 2u) + 1, 0, last)), row)).x;
    return bytes_between(low, high, at);
}

// The four bytes that begin `at` modulo 4 bytes into the first of two neighbouring words.
fn bytes_between(low: u32, high: u32, at: i32) -> u32 {
    let shift = (u32(at) & 3u) * 8u;
    return (low >> shift) | ((high << 1u) << (31u - shift));
}

// |a - b| - 1 of four bytes below 128, as a sum of bytes that may borrow from each other. With the top bit set no byte
// of the difference does; a negative one is complemented.
fn differences(a: u32, b: u32) -> u32 {
    let difference = (a | TOP_BITS) - b;
    let positive = (difference >> 7u) & 0x01010101u;
    return (difference ^ (positive + 0x7f7f7f7fu)) - positive;
}

// The key of the slice's smallest sum in one row; the right view rolls along.
// low[d], high[d]: the smallest key so far of the right pixel that disparity d, HALF + d sees from this column; one
// column to the left, the same right pixel is seen by the disparity before.
fn least_of_row(pairs: ptr<function, array<u32, HALF>>, low: ptr<function, Pairs>, high: ptr<function, Pairs>, k: u32,
                last_slice: bool) -> u32 {
    var least = 0xffffffffu;
    let middle = (*high)[k][0];
    let beyond = select(subgroupShuffleDown((*low)[k][0], 1u) + SLICE, KEY_NONE, last_slice);
    for (var p = 0u; p < HALF; p++) {
        let pair = (*pairs)[p];
        let low_key = (pair << 16u) | p;
        let high_key = (pair & 0xffff0000u) | (p + HALF);
        least = min(least, min(low_key ^ REVERSED, high_key ^ REVERSED));
        (*low)[k][p] = min(select((*low)[k][min(p + 1u, HALF - 1u)], middle, p + 1u == HALF), low_key);
        (*high)[k][p] = min(select((*high)[k][min(p + 1u, HALF - 1u)], beyond, p + 1u == HALF), high_key);
    }
    return least;
}

fn least_of_slices(value: u32) -> u32 {
    var least = value;
    if PARTS > 1u {
        least = min(least, subgroupShuffleXor(least, 1u));
    }
    if PARTS > 2u {
        least = min(least, subgroupShuffleXor(least, 2u));
    }
    if PARTS > 4u {
        least = min(least, subgroupShuffleXor(least, 4u));
    }
    return least;
}

fn any_of_slices(value: u32) -> u32 {
    var bits = value;
    if PARTS > 1u {
        bits |= subgroupShuffleXor(bits, 1u);
    }
    if PARTS > 2u {
        bits |= subgroupShuffleXor(bits, 2u);
    }
    if PARTS > 4u {
        bits |= subgroupShuffleXor(bits, 4u);
    }
    return bits;
}

// Bits d - 1, d and d + 1, as far as they are within 0 .. 15.
fn neighbourhood(d: i32) -> u32 {
    return ((7u << u32(clamp(d + 2, 0, 19))) >> 3u) & 0xffffu;
}

// What the slice knows of the winner `best` of a row: the sums before and after it in bits 0 to 14 and 16 to 30, whether
// another one's sum is at most `limit` in bit 31.
fn neighbours(pairs: ptr<function, array<u32, HALF>>, best: i32, limit: u32) -> u32 {
    let others = ~(neighbourhood(best) | (neighbourhood(best - i32(HALF)) << 16u));
    let most = (limit | 0x8000u) * 0x10001u;
    let before = best - 1;
    let after = best + 1;
    let before_pair = select(before, before - i32(HALF), before >= i32(HALF));
    let after_pair = select(after, after - i32(HALF), after >= i32(HALF));
    var a = 0u;
    var c = 0u;
    var rivals = 0u;
    for (var p = 0u; p < HALF; p++) {
        let pair = (*pairs)[p];
        if SUBPIXEL != SUBPIXEL_OFF {
            a = select(a, pair, before_pair == i32(p));
            c = select(c, pair, after_pair == i32(p));
        }
        if UNIQUENESS > 0u {
            rivals |= (most - pair) & (others << (15u - p));
        }
    }
    a = select(a & 0xffffu, a >> 16u, before >= i32(HALF));
    c = select(c << 16u, c & 0xffff0000u, after >= i32(HALF));
    let rival = select(0u, 0x80000000u, (rivals & 0x80008000u) != 0u);
    return a | c | rival;
}

// The disparity in 1/16 px at column x.
fn refined(key: u32, around: u32, x: i32) -> i32 {
    let best = key & 0xffffu;
    let here = key >> 16u;
    let before = around & 0x7fffu;
    let after = (around >> 16u) & 0x7fffu;
    var value = 16 * (frame.min_disparity + i32(best));
    if SUBPIXEL != SUBPIXEL_OFF {
        value += select(0, refinement(before, here, after), best > 0u && best + 1u < DISPARITIES);
    }
    let unique = UNIQUENESS == 0u || around < 0x80000000u;
    return select(INVALID, value, unique && points_inside(x, value));
}

fn append(unwritten: ptr<function, Unwritten>, own: u32, value: i32) {
    let words = (*unwritten)[own];
    (*unwritten)[own] = array(
        (words[0] << 16u) | (u32(value) & 0xffffu), (words[1] << 16u) | (words[0] >> 16u),
        (words[2] << 16u) | (words[1] >> 16u));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(subgroup_invocation_id) lane: u32) {
    // Neighbouring invocations of a workgroup are neighbours in a subgroup: see shared_path_subgroup.wgsl.
    let slice = id.x % PARTS;
    let first_lane = lane - slice;
    let row = id.x / PARTS * STRIP;
    let top = i32(dispatch.first_row + row) - i32(frame.block_radius);
    let width = i32(frame.width);
    let base = i32(slice * SLICE);

    // All windows begin empty. When the last column is reached they are filled, and what entered before has left again.
    let start = (width - 1 + i32(SLICE + BLOCK)) | 3;
    let end = min(frame.min_disparity, 0) & ~3; // whole groups of four steps
    var entering_windows: Windows;
    var leaving_windows: Windows;
    var sums: Pairs;
    var low: Pairs;
    var high: Pairs;
    var left_unwritten: Unwritten;
    var right_unwritten: Unwritten;
    var labels_unwritten: Unwritten;
    // Right pixels that no left pixel sees.
    if frame.min_disparity > 0 {
        for (var word = max(width - frame.min_disparity, 0) >> 1u; word <= (width - 1) >> 1u; word++) {
            for (var own = 0u; own < OWN; own++) {
                let at = row + own * PARTS + slice;
                if at < dispatch.rows {
                    right_map[(dispatch.map_row + at) * frame.map_stride + u32(word)] = 0x80008000u;
                }
            }
        }
    }
    for (var phase = 0u; phase < 2u; phase++) {
        for (var k = 0u; k < STRIP; k++) {
            for (var p = 0u; p < HALF; p++) {
                low[k][p] = KEY_NONE;
                high[k][p] = KEY_NONE;
            }
        }
        for (var own = 0u; own < OWN; own++) {
            left_unwritten[own] = array(0x80008000u, 0x80008000u, 0x80008000u);
            right_unwritten[own] = array(0x80008000u, 0x80008000u, 0x80008000u);
        }
        let from_x = select(start, width - 1, phase == 1u);
        let to_x = select(width, end, phase == 1u);
        for (var x4 = from_x & ~3; x4 + 3 >= to_x; x4 -= 4) {
            // Four pixels of each row, for four steps.
            let seen = width - 1 + 2 * i32(frame.block_radius) - x4 - 3 + base + i32(SLICE) - 1;
            let missing = u32(clamp(x4 + 3 + i32(BLOCK) - start, 0, 4));
            let left_mask = select(0xffffffffu >> (8u * (missing & 3u)), 0u, missing == 4u);
            let right_mask = select(0xffffffffu << (8u * (missing & 3u)), 0u, missing == 4u);
            var entering_left = Words();
            var entering_right = Words();
            var leaving_left = Words();
            var leaving_right = Words();
            for (var j = 0u; j < ROWS; j++) {
                let y = row_at(top, j);
                entering_left[j] = left_bytes(x4, y);
                leaving_left[j] = left_bytes(x4 + i32(BLOCK), y) & left_mask;
                entering_right[j] = right_bytes(seen, y);
                leaving_right[j] = right_bytes(seen - i32(BLOCK), y) & right_mask;
            }
            for (var x = min(x4 + 3, from_x); x >= max(x4, to_x); x--) {
                let shift = 8u * (u32(x) & 3u);
                var entering_words = Words();
                var leaving_words = Words();
                var entering_values = Words();
                var leaving_values = Words();
                for (var j = 0u; j < ROWS; j++) {
                    entering_values[j] = ((entering_left[j] >> shift) & 0xffu) * 0x01010101u;
                    leaving_values[j] = ((leaving_left[j] >> shift) & 0xffu) * 0x01010101u;
                    entering_words[j] = (entering_windows[j][0] >> 8u) | ((entering_right[j] << shift) & 0xff000000u);
                    leaving_words[j] = (leaving_windows[j][0] >> 8u) | ((leaving_right[j] << shift) & 0xff000000u);
                }
                for (var w = 0u; w < QUARTER; w++) {
                    // The column that enters minus the one that leaves: bytes of a row biased by 128, their sums not.
                    var even = Words();
                    var odd = Words();
                    var even_sum = 0xffffffffu - BLOCK * 128u * 0x10001u + 1u;
                    var odd_sum = even_sum;
                    for (var j = 0u; j < ROWS; j++) {
                        entering_windows[j][w] =
                            select(entering_windows[j][min(w + 1u, QUARTER - 1u)], entering_words[j], w + 1u == QUARTER);
                        leaving_windows[j][w] =
                            select(leaving_windows[j][min(w + 1u, QUARTER - 1u)], leaving_words[j], w + 1u == QUARTER);
                        let change = differences(entering_values[j], entering_windows[j][w])
                            - differences(leaving_values[j], leaving_windows[j][w]) + TOP_BITS;
                        even[j] = change & EVEN_BYTES;
                        odd[j] = (change >> 8u) & EVEN_BYTES;
                        even_sum += even[j];
                        odd_sum += odd[j];
                        if j + 1u >= BLOCK {
                            let k = j + 1u - BLOCK;
                            sums[k][w] += even_sum;
                            sums[k][QUARTER + w] += odd_sum;
                            even_sum -= even[k];
                            odd_sum -= odd[k];
                        }
                    }
                }
                var keys = array<u32, OWN>();
                var around = array<u32, OWN>();
                var right_keys = array<u32, OWN>();
                for (var k = 0u; k < STRIP; k++) {
                    var pairs = sums[k];
                    if PADDED {
                        for (var p = 0u; p < HALF; p++) {
                            let d = slice * SLICE + p;
                            pairs[p] |= select(0u, SUM_NONE, d >= DISPARITIES)
                                | select(0u, SUM_NONE << 16u, d + HALF >= DISPARITIES);
                        }
                    }
                    if SHIFTED == 1u {
                        for (var p = 0u; p < HALF; p++) {
                            pairs[p] |= select(0u, SUM_NONE * 0x10001u, x < 0);
                        }
                    }
                    let least = least_of_row(&pairs, &low, &high, k, slice + 1u == PARTS);
                    let own_first = select(u32(base), 0u - u32(base), STEREO_BM == 1u);
                    let key = least_of_slices(least + own_first) ^ REVERSED;
                    let limit = min(largest_rival(key >> 16u), SUM_NONE - 1u);
                    let known = any_of_slices(neighbours(&pairs, i32(key & 0xffffu) - base, limit));
                    let right_key = subgroupShuffle(low[k][0], first_lane);
                    let own = slice == k % PARTS;
                    keys[k / PARTS] = select(keys[k / PARTS], key, own);
                    around[k / PARTS] = select(around[k / PARTS], known, own);
                    right_keys[k / PARTS] = select(right_keys[k / PARTS], right_key, own);
                }
                for (var own = 0u; own < OWN; own++) {
                    append(&left_unwritten, own, refined(keys[own], around[own], x));
                    if LABELS == 1u {
                        append(&labels_unwritten, own, i32(keys[own] & 0xffffu));
                    }
                    let seen = 16 * (frame.min_disparity + i32(right_keys[own] & 0xffffu));
                    append(&right_unwritten, own, select(seen, INVALID, right_keys[own] >= KEY_NONE));
                }
            }
            // The right view's pixels lie min_disparity further left: where that is odd, words end between two groups.
            let right4 = x4 - frame.min_disparity;
            let left_word = x4 >> 1u;
            let right_word = (right4 + 1) >> 1u;
            for (var own = 0u; own < OWN; own++) {
                let at = row + own * PARTS + slice;
                let words = (dispatch.map_row + at) * frame.map_stride;
                let stride = select(0, i32(frame.map_stride), phase == 1u && at < dispatch.rows);
                for (var word = 0u; word < 2u; word++) {
                    let l = left_word + i32(word);
                    if l >= 0 && l < stride {
                        left_map[words + u32(l)] = left_unwritten[own][word];
                        if LABELS == 1u {
                            right_map[frame.map_words + words + u32(l)] = labels_unwritten[own][word];
                        }
                    }
                    let r = right_word + i32(word);
                    if r >= 0 && r < stride {
                        let between = (right_unwritten[own][word] >> 16u) | (right_unwritten[own][word + 1u] << 16u);
                        right_map[words + u32(r)] = select(right_unwritten[own][word], between, (right4 & 1) == 1);
                    }
                }
            }
        }
    }
}
