// Appended to the kernels that walk a row from right to left and choose the winner: uniqueness, subpixel, its margin for
// the confidence and its label (u16, each as a map behind the right one, in this order) and the right view. The walk starts or ends outside the image where a
// minimum disparity other than 0 shifts the right view.
// Reference: src/reference/winner/winner.rs
//
// A candidate is the key cost << 12 | d: the smallest key is the smallest cost, and of those the smallest disparity. By the
// rules of StereoBM it is the largest disparity of the left view: REVERSED turns its bits.
// d < 2^12. Disparities beyond the range, and pixels beyond the row, cost COST_NONE: totals_* says how costs are held.

// Disparities of a member.
const OWN: u32 = 16u * OWN_QUADS;

const REVERSED: u32 = 0xfffu * STEREO_BM;

alias Keys = array<array<vec4<u32>, 4>, OWN_QUADS>;

fn no_keys() -> Keys {
    let none = vec4(COST_NONE << 12u);
    var keys: Keys;
    for (var q = 0u; q < OWN_QUADS; q++) {
        keys[q] = array(none, none, none, none);
    }
    return keys;
}

// The smallest key and the second smallest of each fourth disparity, from the first four on.
struct Least {
    first: vec4<u32>,
    second: vec4<u32>,
}

// The two pixels of a word meet here: the right one is kept until the left one is known.
struct RowWriter {
    left_kept: i32,
    margin_kept: i32,
    label_kept: i32,
    right_kept: i32,
}

// Of the left view.
struct Winner {
    value: i32,     // disparity in 1/16 px
    margin: i32,    // over its best rival, 0 to 255
    label: i32,     // its index, whether it is valid or not
}

fn row_steps() -> i32 {
    return i32(frame.width) + abs(frame.min_disparity);
}

fn row_start() -> i32 {
    return i32(frame.width) - 1 + max(frame.min_disparity, 0);
}

// Known at compile time for the usual minimum of 0: a branch costs a copy of all values live across it.
fn inside_row(x: i32) -> bool {
    return SHIFTED == 0u || (x >= 0 && x < i32(frame.width));
}

// Chooses at column x, and writes what is complete: of the left map if x lies in the image, of the right map if the
// right pixel seen by disparity 0 does.
fn choose(totals: ptr<function, Totals>, diagonal: ptr<function, Keys>,
          kept: ptr<function, RowWriter>, row: u32, x: i32, writes: bool) {
    if inside_row(x) {
        hide_beyond(totals);
    } else {
        *totals = no_totals();
    }
    // On its way to the member before, a key's disparity is counted from that member's first one.
    let leaving = (*diagonal)[0][0].x + OWN;
    let least = roll(totals, diagonal);
    let own_first = select(member * OWN, 0u - member * OWN, STEREO_BM == 1u);
    let around = exchange(lowest(least.first) + own_first, leaving, 0u);
    let best = winner(totals, least, around.least ^ REVERSED, x);
    let seen_value = seen_at_zero(diagonal, around.above);
    if inside_row(x) {
        if (x & 1) == 0 && writes {
            let at = row * frame.map_stride + (u32(x) >> 1u);
            left_map[at] = map_word(best.value, (*kept).left_kept);
            if CONFIDENCE == 1u {
                right_map[frame.map_words + at] = map_word(best.margin, (*kept).margin_kept);
            }
            if LABELS == 1u {
                right_map[(1u + CONFIDENCE) * frame.map_words + at] = map_word(best.label, (*kept).label_kept);
            }
        }
        (*kept).left_kept = best.value;
        (*kept).margin_kept = best.margin;
        (*kept).label_kept = best.label;
    }
    let seen = x - frame.min_disparity;
    if inside_row(seen) {
        if (seen & 1) == 0 && writes {
            right_map[row * frame.map_stride + (u32(seen) >> 1u)] = map_word(seen_value, (*kept).right_kept);
        }
        (*kept).right_kept = seen_value;
    }
}

fn keys(costs: vec4<u32>, k: u32) -> vec4<u32> {
    return (costs << vec4(12u)) | (vec4(4u * k) + vec4(0u, 1u, 2u, 3u));
}

// The winner of the pixel at column x, whose smallest key is `best_key`.
fn winner(totals: ptr<function, Totals>, least: Least, best_key: u32, x: i32) -> Winner {
    let best = best_key & 0xfffu;
    let own_best = best - member * OWN;
    let cost = best_key >> 12u;
    // The costs at the neighbours of the winner; members that do not hold them have 0.
    var before = 0u;
    var after = 0u;
    if SUBPIXEL != SUBPIXEL_OFF {
        let lower = own_best - 1u;
        let upper = own_best + 1u;
        for (var q = 0u; q < OWN_QUADS; q++) {
            before = select(before, total_of(totals, q, lower & 15u), (lower >> 4u) == q);
            after = select(after, total_of(totals, q, upper & 15u), (upper >> 4u) == q);
        }
    }
    // The smallest cost beyond them, its best rival's. The winner and its neighbours are of three different fourths of the disparities:
    // where one of them is the smallest of its fourth, the second smallest counts.
    let near = (((least.first ^ vec4(REVERSED)) & vec4(0xfffu)) + vec4(1u) - vec4(own_best)) <= vec4(2u);
    let rival = lowest(select(least.first, least.second, near)) >> 12u;
    let known = neighbours_and_rival(vec3(before, after, rival));
    var value = 16 * (frame.min_disparity + i32(best));
    if SUBPIXEL != SUBPIXEL_OFF && best > 0u && best + 1u < DISPARITIES {
        value += refinement(known.x, cost, known.y);
    }
    let limit = min(largest_rival(cost), COST_NONE - 1u);
    // By the rules of StereoSGBM nothing is less than a cost of 0.
    let nothing_less = OPENCV_RULES == 1u && STEREO_BM == 0u && cost == 0u;
    if (UNIQUENESS > 0u && known.z <= limit && !nothing_less) || !points_inside(x, value) {
        value = INVALID;
    }
    var margin = 255u;
    if CONFIDENCE == 1u && known.z < COST_NONE {
        margin = margin_over(cost, known.z);
    }
    return Winner(value, i32(margin), i32(best));
}

// The right view: diagonal[d] is the smallest key so far of the right pixel that disparity d sees from this column;
// one column to the left, the same right pixel is seen by disparity d - 1. What enters at a member's last disparity is not known yet.
// Returns the smallest keys of this column.
fn roll(totals: ptr<function, Totals>, diagonal: ptr<function, Keys>) -> Least {
    var first = vec4(0xffffffffu);
    var second = vec4(0xffffffffu);
    for (var q = 0u; q < OWN_QUADS; q++) {
        let after = select((*diagonal)[min(q + 1u, OWN_QUADS - 1u)][0].x, 0xffffffffu, q + 1u == OWN_QUADS);
        for (var i = 0u; i < 4u; i++) {
            let here = keys(totals_at(totals, q, i), 4u * q + i);
            let own = here ^ vec4(REVERSED);
            second = min(second, max(first, own));
            first = min(first, own);
            let above = select((*diagonal)[q][min(i + 1u, 3u)].x, after, i == 3u);
            (*diagonal)[q][i] = min(vec4((*diagonal)[q][i].yzw, above), here);
        }
    }
    return Least(first, second);
}

// The right pixel seen by disparity 0, when it is known what enters.
fn seen_at_zero(diagonal: ptr<function, Keys>, entering: u32) -> i32 {
    (*diagonal)[OWN_QUADS - 1u][3].w = min((*diagonal)[OWN_QUADS - 1u][3].w, min(entering, COST_NONE << 12u));
    let key = (*diagonal)[0][0].x;
    return select(16 * (frame.min_disparity + i32(key & 0xfffu)), INVALID, (key >> 12u) == COST_NONE);
}
