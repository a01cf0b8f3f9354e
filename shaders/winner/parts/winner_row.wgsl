// Appended to the kernels that walk a row from right to left and choose the winner: uniqueness, subpixel, its margin for
// the confidence and its label (u16, each as a map behind the right one, in this order) and the right view. The walk starts or ends outside the image where a
// minimum disparity other than 0 shifts the right view.
// Reference: src/reference/winner/winner.rs
//
// A candidate is the key cost << 12 | d: the smallest key is the smallest cost, and of those the smallest disparity.
// cost < 2^20 and d < 2^12. Disparities beyond the range, and pixels beyond the row, cost COST_NONE.
const COST_NONE: u32 = 0xfffffu;

// Disparities of a member.
const OWN: u32 = 16u * OWN_QUADS;

fn no_costs(value: u32) -> Costs {
    var costs: Costs;
    for (var q = 0u; q < OWN_QUADS; q++) {
        costs[q] = array(vec4(value), vec4(value), vec4(value), vec4(value));
    }
    return costs;
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
fn choose(costs: ptr<function, Costs>, diagonal: ptr<function, Costs>,
          kept: ptr<function, RowWriter>, row: u32, x: i32, writes: bool) {
    if inside_row(x) {
        for (var q = 0u; q < OWN_QUADS; q++) {
            for (var i = 0u; i < 4u; i++) {
                let outside = unpack(beyond(q)[i]) != vec4(0u);
                (*costs)[q][i] = select((*costs)[q][i], vec4(COST_NONE), outside);
            }
        }
    } else {
        *costs = no_costs(COST_NONE);
    }
    // On its way to the member before, a key's disparity is counted from that member's first one.
    let around = exchange(least_key(costs) + member * OWN, (*diagonal)[0][0].x + OWN, 0u);
    let best = winner(costs, around.least, x);
    let seen_value = roll(diagonal, costs, around.above);
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

fn least_key(costs: ptr<function, Costs>) -> u32 {
    var least = vec4(0xffffffffu);
    for (var q = 0u; q < OWN_QUADS; q++) {
        for (var i = 0u; i < 4u; i++) {
            least = min(least, keys((*costs)[q][i], 4u * q + i));
        }
    }
    return lowest(least);
}

// The winner of the pixel at column x, whose smallest key is `least`.
fn winner(costs: ptr<function, Costs>, least: u32, x: i32) -> Winner {
    let best = least & 0xfffu;
    let own_best = best - member * OWN;
    let cost = least >> 12u;
    // The costs at the neighbours of the winner, and the smallest cost beyond them: its best rival's.
    var before = vec4(0u);
    var after = vec4(0u);
    var rival = vec4(COST_NONE);
    for (var q = 0u; q < OWN_QUADS; q++) {
        for (var i = 0u; i < 4u; i++) {
            let c = (*costs)[q][i];
            let d = vec4(4u * (4u * q + i)) + vec4(0u, 1u, 2u, 3u);
            let is_before = d + vec4(1u) == vec4(own_best);
            let is_after = d == vec4(own_best + 1u);
            if SUBPIXEL != SUBPIXEL_OFF {
                before = select(before, c, is_before);
                after = select(after, c, is_after);
            }
            if UNIQUENESS > 0u || CONFIDENCE == 1u {
                rival = min(rival, select(c, vec4(COST_NONE), is_before | is_after | (d == vec4(own_best))));
            }
        }
    }
    let known = neighbours_and_rival(vec3(
        before.x | before.y | before.z | before.w,
        after.x | after.y | after.z | after.w,
        lowest(rival)));
    var value = 16 * (frame.min_disparity + i32(best));
    if SUBPIXEL != SUBPIXEL_OFF && best > 0u && best + 1u < DISPARITIES {
        value += refinement(known.x, cost, known.y);
    }
    // The largest rival that fails the uniqueness test rival * (100 - UNIQUENESS) > cost * 100.
    let limit = min(cost * 100u / (100u - UNIQUENESS), COST_NONE - 1u);
    if (UNIQUENESS > 0u && known.z <= limit) || !points_inside(x, value) {
        value = INVALID;
    }
    var margin = 255u;
    if CONFIDENCE == 1u && known.z < COST_NONE {
        margin = margin_over(cost, known.z);
    }
    return Winner(value, i32(margin), i32(best));
}

// The right view: diagonal[d] is the smallest key so far of the right pixel that disparity d sees from this column;
// one column to the left, the same right pixel is seen by disparity d - 1. Returns the right pixel seen by disparity 0.
fn roll(diagonal: ptr<function, Costs>, costs: ptr<function, Costs>, entering: u32) -> i32 {
    for (var q = 0u; q < OWN_QUADS; q++) {
        let after = select((*diagonal)[min(q + 1u, OWN_QUADS - 1u)][0].x, min(entering, COST_NONE << 12u), q + 1u == OWN_QUADS);
        for (var i = 0u; i < 4u; i++) {
            let above = select((*diagonal)[q][min(i + 1u, 3u)].x, after, i == 3u);
            let seen = vec4((*diagonal)[q][i].yzw, above);
            (*diagonal)[q][i] = min(seen, keys((*costs)[q][i], 4u * q + i));
        }
    }
    let key = (*diagonal)[0][0].x;
    return select(16 * (frame.min_disparity + i32(key & 0xfffu)), INVALID, (key >> 12u) == COST_NONE);
}
