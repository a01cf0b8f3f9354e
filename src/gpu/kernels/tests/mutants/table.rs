//! The mutants.

use crate::gpu::kernels::tests::settings::*;
use crate::{Census, Cost, Fill, Params, Paths, Prefilter};

/// A change to a shader, and settings that show it.
pub(super) struct Mutant {
    pub(super) kernel: &'static str,
    pub(super) from: &'static str,
    pub(super) to: &'static str,
    pub(super) change: fn(&mut Params),
}

const fn mutant(kernel: &'static str, from: &'static str, to: &'static str, change: fn(&mut Params)) -> Mutant {
    Mutant { kernel, from, to, change }
}

/// One rule a row: a weight, a rounding, a border, a tie, a penalty, a test of the winner.
pub(super) const MUTANTS: &[Mutant] = &[
    mutant("gray", "16384u", "0u", |_| ()),
    mutant("gray", "3735u", "3734u", |_| ()),
    mutant("gray", "frame.width) - 1)", "frame.width) - 2)", |_| ()),
    mutant("prefilter", "low_bytes(-x)", "low_bytes(-x - 1)", |_| ()),
    mutant("prefilter", "low_bytes(last - x)", "low_bytes(last - x + 2)", |_| ()),
    mutant("prefilter", "frame.height) - 1)", "frame.height) - 2)", |_| ()),
    mutant("prefilter", "dispatch.own.lead", "(dispatch.own.lead + 1)", |_| ()),
    mutant("prefilter", "vec4(-128 * divisor)", "vec4(-12 * divisor)", |params| {
        params.prefilter = Prefilter::Normalized
    }),
    mutant("prefilter", "4 * centre", "3 * centre", |params| params.prefilter = Prefilter::Normalized),
    mutant("deep_gray", "vec4(x < 0)", "vec4(x < -8)", |_| ()),
    mutant("window_columns", "dy < radius", "dy < radius - 1", |params| params.prefilter = Prefilter::Normalized),
    mutant("window_columns", "frame.height) - 1)", "frame.height) - 2)", |params| {
        params.prefilter = Prefilter::Normalized
    }),
    mutant("window_sums", "frame.width) - 1)", "frame.width) - 2)", |params| params.prefilter = Prefilter::Normalized),
    mutant("descriptors", "~(a ^ b) & low_bits", "low_bits", |params| {
        (params.cost, params.prefilter) = (Cost::Census, Prefilter::None);
    }),
    mutant("descriptors", "moved(other, -towards)", "moved(other, towards)", |params| {
        params.cost = Cost::Census;
        params.census = Census::CentreSymmetric;
    }),
    mutant("descriptors", "low_bytes(last - x)", "low_bytes(last - x + 2)", |params| params.cost = Cost::CensusSobel),
    mutant("descriptors", "vec4(half)", "vec4(0)", |params| params.cost = Cost::ZeroMeanSad),
    mutant("descriptors", "min(before, after)", "before", |params| params.cost = Cost::BirchfieldTomasi),
    mutant("matching_cost_small", "vec4(2u)) & vec4(0x3f3f3f3fu)", "vec4(3u)) & vec4(0x1f1f1f1fu)", |params| {
        params.cost = Cost::BirchfieldTomasiGray;
    }),
    mutant("matching_cost_small", "~quarter", "quarter", |params| {
        (params.cost, params.prefilter) = (Cost::BirchfieldTomasiGray, Prefilter::None);
    }),
    mutant("prefilter", "2 * cap", "2 * cap - 1", |params| params.prefilter = Prefilter::Sobel),
    mutant("prefilter", "return root;", "return root + 1u;", |params| params.prefilter = Prefilter::Sobel),
    mutant("halve", "+ 2u) >> 2u", "+ 1u) >> 2u", mutual),
    mutant("halve", "dispatch.lines - 1u", "dispatch.lines - 2u", mutual),
    mutant("mi_histogram", "+ 8) >> 4u", "+ 7) >> 4u", mutual),
    mutant("mi_histogram", "value * i32(1u << dispatch.own.halvings)", "value", mutual),
    mutant("mi_smooth", "6u * middle", "5u * middle", mutual),
    mutant("mi_smooth", "fraction) * 11u", "fraction) * 9u", mutual),
    mutant("mi_smooth", "vec4(values.x), four < 0", "values, four < 0", |params| {
        mutual(params);
        params.prefilter = Prefilter::XSobel;
    }),
    mutant("mi_marginals", "select(256u, 1u, id.x < 256u)", "select(255u, 1u, id.x < 256u)", mutual),
    mutant("mi_range", "max(found.y, ranges[l].y)", "ranges[l].y", mutual),
    mutant("mi_table", "vec4(span / 2u)", "vec4(0u)", mutual),
    mutant("mi_table", "vec4(span == 0u)", "vec4(false)", mutual),
    mutant("mi_table", "vec4(32u)", "vec4(0u)", mutual),
    mutant("cost_columns", "vec4(3u)) * 8u", "vec4(1u)) * 8u", |params| {
        mutual(params);
        wide(params);
    }),
    mutant("matching_cost_pixels", "vec4(3u)) * 8u", "vec4(1u)) * 8u", mutual),
    mutant("matching_cost_parallel", "vec2(columns.w, l)", "vec2(columns.w, 0u)", |params| {
        mutual(params);
        per_subgroup(params);
    }),
    mutant("cost_columns", "frame.height) - 1)", "frame.height))", wide),
    mutant("cost_columns", "here + r)", "here + r - 1)", wide),
    mutant("cost_columns", "low * low", "low * low + 1u", |params| params.cost = Cost::Ssd),
    mutant("matching_cost", "1u << 23u", "1u << 22u", wide),
    mutant("matching_cost", "frame.cost_scale", "(frame.cost_scale + 9000u)", wide),
    mutant("matching_cost", "c < begin + reach", "c < begin + reach - 1u", wide),
    mutant("matching_cost", "min(begin + SPAN,", "min(begin + SPAN - 1u,", |params| {
        wide(params);
        per_subgroup(params);
    }),
    mutant("matching_cost_small", "1u << 23u", "1u << 22u", |_| ()),
    mutant("matching_cost_small", "frame.height) - 1)", "frame.height) - 2)", |_| ()),
    mutant("matching_cost_small", "start - four,", "start - four + 1u,", |_| ()),
    mutant("matching_cost_small", "window(start + 1u,", "window(start,", |params| params.min_disparity = -12),
    mutant("matching_cost_small", "values[j][p] >>= 8u", "values[j][p] >>= 16u", |_| ()),
    mutant("matching_cost_small", "c < columns", "c + 1u < columns", |_| ()),
    mutant("matching_cost_small", "- kept[0]", "- kept[1]", |_| ()),
    mutant("matching_cost_pixels", "24u - 8u * k", "8u * k", |params| params.block = 1),
    mutant("matching_cost_pixels", "inside > 2u", "inside > 9u", |params| params.block = 1),
    mutant("matching_cost_pixels", "vec4(entering[p], seen[p].xyz)", "seen[p]", |params| params.block = 1),
    mutant("matching_cost_pixels", "0x01010101u <<", "0u <<", |params| {
        (params.block, params.cost, params.prefilter) = (1, Cost::CensusSobel, Prefilter::None);
    }),
    mutant("matching_cost_small", "(a ^ b) & c", "(a ^ b) | c", |params| params.cost = Cost::Census),
    mutant("matching_cost_small", "2u * differing_bits", "differing_bits", |params| params.cost = Cost::CensusSobel),
    mutant("matching_cost_small", "+ vec4(8u)", "+ vec4(7u)", |params| params.cost = Cost::AdCensus),
    mutant("matching_cost_small", "there - above(there, back)", "there", |params| params.cost = Cost::BirchfieldTomasi),
    mutant("matching_cost_small", "((a ^ b) >> vec4(1u))", "((a | b) >> vec4(1u))", |params| params.color_cost = true),
    mutant("matching_cost_small", "j % SUMMABLE == 0u", "j % (SUMMABLE + 3u) == 0u", |params| {
        params.prefilter_cap = 63
    }),
    mutant("matching_cost_parallel", "1u << 23u", "1u << 22u", per_subgroup),
    mutant("matching_cost_parallel", "frame.height) - 1)", "frame.height) - 2)", per_subgroup),
    mutant("matching_cost_parallel", "- kept[0]", "- kept[1]", per_subgroup),
    mutant("matching_cost_parallel", "values[p][c >> 2u], (c & 3u)", "values[p][c >> 2u], (i & 3u)", per_subgroup),
    mutant("matching_cost_parallel", "% SUMMABLE == 0u", "% (SUMMABLE + 3u) == 0u", |params| {
        per_subgroup(params);
        params.prefilter_cap = 63;
    }),
    mutant("matching_cost_parallel", "+ REACH;", "+ REACH - 1u;", per_subgroup),
    mutant("sgm_aggregate", "frame.p1", "frame.p2", |_| ()),
    mutant("sgm_aggregate", "frame.p2", "frame.p1", |_| ()),
    mutant("sgm_aggregate", "frame.p2", "frame.p1", eight_paths),
    mutant("sgm_aggregate", "x >= width", "x > width", eight_paths),
    mutant("sgm_aggregate", "select(below, NONE, member == 0u)", "below", per_subgroup),
    mutant("sgm_aggregate", "subgroupShuffleXor(least_of_all, 1u << bit)", "least", per_subgroup),
    mutant("sgm_aggregate", "places[start + member_of(member + 1u)].y", "NONE", per_subgroup),
    mutant("sgm_aggregate", "places[start + i].x", "places[start].x", per_subgroup),
    mutant("sgm_aggregate", "select(after, (*state)[s]", "select(0u, (*state)[s]", |params| params.disparities = 64),
    mutant("sgm_aggregate", "stored >> vec4(32u)", "stored >> vec4(31u)", |params| params.disparities = 64),
    mutant("sgm_aggregate", "i32(dispatch.first_line", "i32(0u * dispatch.first_line", |_| ()),
    mutant("sgm_aggregate", "var place = dispatch.own.place", "var place = 0", adaptive),
    mutant("sgm_aggregate", "select(15, 0, forward)", "15", adaptive),
    mutant("sgm_aggregate", "dispatch.own.penalties_from +", "0u +", sixteen),
    mutant("sgm_aggregate", "select(-width, width", "select(-width, width - 1", sixteen),
    mutant("sgm_aggregate", "dispatch.entry", "0", sixteen),
    mutant("penalties", "vec4(f32(P2_STEP)))", "vec4(f32(P2_STEP + 2u)))", adaptive),
    mutant("penalties", "frame.p1 / 2u", "frame.p1 / 4u", adaptive),
    mutant("penalties", "+ 0.5)", "- 0.5)", adaptive),
    mutant("penalties", "vec4(0.0), outside", "vec4(40.0), outside", adaptive),
    mutant("penalties", "vec4(3.0))", "vec4(4.0))", adaptive_both),
    mutant("penalties", "max(quotient, vec4(8u))", "max(quotient, vec4(9u))", adaptive_both),
    mutant("penalties", "min(max(quotient, vec4(8u)), vec4(frame.p1))", "max(quotient, vec4(8u))", |params| {
        adaptive_both(params);
        params.p1 = 5;
    }),
    mutant("penalties_lines", "* PENALTY_BYTES + j) * rows", "* PENALTY_BYTES) * rows", adaptive_both),
    mutant("sgm_aggregate", "both >> 8u", "frame.p1", adaptive_both),
    mutant("sgm_aggregate", "both & 255u", "frame.p2", adaptive_both),
    mutant("sgm_aggregate", "select(7, 0, forward)", "7", adaptive_both),
    mutant("second_cost", "PATHS * 0x10001u", "PATHS * 0x10000u", two_passes),
    mutant("second_cost", "PATH_BITS + 1u", "PATH_BITS", two_passes),
    mutant("second_cost", "32768u / PATHS + 1u", "32768u / PATHS", |params| {
        (params.passes, params.paths) = (2, Paths::Three);
    }),
    mutant("second_cost", "own + (*t)[0][w]", "own", two_passes),
    mutant("second_cost", "dispatch.volume_row * frame.volume_stride", "0u", two_passes),
    mutant("penalties_lines", "starts || leaves", "starts", sixteen),
    mutant("penalties_lines", "id.y / rows * 16u * rows + id.y % rows", "id.y * 16u", sixteen),
    mutant("winner", "known, x + 1", "known, x", adaptive),
    mutant("winner", "i / 3u * dispatch.slot", "0u", sixteen),
    mutant("winner", "dispatch.volume_row * frame.volume_stride", "0u", |_| ()),
    mutant("winner", "lowest(least.first) + own_first", "lowest(least.first)", per_subgroup),
    mutant("winner", "min(entering, COST_NONE << 12u)", "COST_NONE << 12u", per_subgroup),
    mutant("winner", "neighbours_and_rival(vec3(", "(vec3(", per_subgroup),
    mutant("winner", "255u * (rival - here)", "256u * (rival - here)", confidence),
    mutant("winner", "vec4(own_best)) <= vec4(2u)", "vec4(own_best)) <= vec4(1u)", confidence),
    mutant("winner", "i32(best));", "i32(best & 6u));", |params| {
        per_subgroup(params);
        labels(params);
    }),
    mutant("winner", "(1u + CONFIDENCE)", "1u", |params| {
        confidence(params);
        labels(params);
    }),
    mutant("winner", "frame.p1", "frame.p2", |_| ()),
    mutant("winner", "PATHS * cost.odd", "cost.odd", |_| ()),
    mutant("winner", "max(first, own)", "own", confidence),
    mutant("winner", "(d & 8u) != 0u", "(d & 4u) != 0u", |_| ()),
    mutant("winner", "k - 1u", "k", |_| ()),
    mutant("winner", "max(before, after)", "before", equiangular),
    mutant("winner", "known.z <= limit", "known.z < limit", |params| params.uniqueness = 1),
    mutant("winner", "(100u - UNIQUENESS)", "(99u - UNIQUENESS)", |params| params.uniqueness = 10),
    mutant("winner", "disparity + 8", "disparity + 7", any),
    mutant("winner", "seen < i32(frame.width)", "seen <= i32(frame.width)", |_| ()),
    mutant("coarse_cost", "column < dispatch.own.width", "column + 1u < dispatch.own.width", bp),
    mutant("coarse_cost", "2u * row + (k >> 1u)", "2u * row", bp),
    mutant("coarse_cost", "exchange(lowest(least), 0u, 0u).least", "lowest(least)", bp_shared),
    mutant("coarse_cost_sums", "a.zw << vec2(16u)", "a.xy << vec2(16u)", bp),
    mutant("coarse_cost_sums", "vec4(LARGEST_TERM)", "vec4(200u)", bp),
    mutant("messages_start", "sent_up(x / 2u, (id.y + 1u) / 2u", "sent_up(x / 2u, id.y / 2u", bp),
    mutant("messages_start", "sent_right((x + 1u) / 2u", "sent_right(x / 2u", bp),
    mutant("messages_start", "coarse_at(2u,", "coarse_at(3u,", bp),
    mutant("messages", "before + weight", "before", bp),
    mutant("messages", "after + weight", "after", bp),
    mutant("messages", "sums * dispatch.own.share", "sums * 16u", bp),
    mutant("messages", "vec4(0x800080u)", "vec4(0x100010u)", bp),
    mutant("messages", "(outside.odd * 0x101u)", "vec4(0u)", bp),
    mutant("messages", "sent_at(RIGHT, row", "sent_at(LEFT, row", bp),
    mutant("messages", "SMOOTHNESS_TRUNCATION >> (edge & 1u)", "SMOOTHNESS_TRUNCATION", bp_edges),
    mutant("messages", ">= vec4(SMOOTHNESS_EDGE)", "> vec4(SMOOTHNESS_EDGE)", bp_edges),
    mutant("messages", "max(x, 1u) - 1u, y", "x, y", bp_edges),
    mutant("messages", "(2u * k + 1u)", "(2u * k + 2u)", bp_quadratic),
    mutant("messages", "below = v.w;", "below = v.z;", bp_quadratic),
    mutant("messages", "lower + far * step", "lower", bp_shared),
    mutant("messages", "upper + far * step", "upper", bp_shared),
    mutant("messages", "(member - 1u - other) * step", "0u", bp_shared),
    mutant("messages", "vec4(others.y) + weight", "vec4(others.x) + weight", bp_shared),
    mutant("messages_coarse", "dispatch.own.odd + dispatch.own.first", "dispatch.own.first", bp),
    mutant("messages_coarse", "low.yw, high.yw", "low.yw, high.xw", bp),
    mutant("winner_beliefs", "unpack(right[w][i])", "unpack(left[w][i])", bp),
    mutant("winner_beliefs", "row * frame.volume_stride + x", "row * frame.volume_stride", bp),
    mutant("block_match", "known.z <= limit", "known.z < limit", |params| {
        bm_pixel(params);
        params.shader_checks = true;
    }),
    mutant("block_match", "2u * frame.block_radius", "2u * frame.block_radius - 1u", bm_columns),
    mutant("block_statistics", "+ vec4(BLOCK)", "+ vec4(BLOCK - 1u)", ncc),
    mutant("block_statistics", "return root;", "return root + 1u;", ncc),
    mutant("block_statistics", "frame.height) - 1)", "frame.height))", ncc),
    mutant("block_statistics", "BLOCK * BLOCK * sums.squares", "(BLOCK * BLOCK - 1u) * sums.squares", ncc),
    mutant("block_match", "left.x * right_sums", "left.y * right_sums", ncc),
    mutant("block_match", "vec4(0.015625)", "vec4(1.5)", ncc),
    mutant("block_match", "vec4(4096u) + part", "vec4(4096u)", ncc),
    mutant("block_match", "frame.width - 1u - u32(x)", "frame.width - u32(x)", ncc),
    mutant("block_match", "max(place, 1u) - 1u", "place", ncc),
    mutant("block_match", "entering.y, last", "0u, last", ncc),
    mutant("block_match", "(*seen).roots[q] = r", "(*seen).roots[q] = s", ncc),
    mutant("block_match", "k - 1u", "k", bm_columns),
    mutant("block_match_small", "frame.height) - 1)", "frame.height) - 2)", bm),
    mutant("block_match_small", "here * 100u", "here * 110u", bm),
    mutant("block_match_small", "here * UNIQUENESS / 100u", "here * UNIQUENESS / 90u", stereo_bm),
    mutant("block_match_small", "(part + 15u)", "(part + 8u)", stereo_bm),
    mutant("block_match_small", "low_key ^ REVERSED", "low_key", stereo_bm_ties),
    mutant("block_match_small", "-i32(part >> 4u)", "-i32((part + 15u) >> 4u)", stereo_bm),
    mutant("winner", "max(here * 100u, 1u) - 1u", "here * 100u", |params| {
        (params.opencv_rules, params.p1, params.p2, params.uniqueness) = (true, 0, 0, 50);
    }),
    mutant("winner", "select(-1, 1, forward)", "1", |params| params.opencv_rules = true),
    mutant("block_match", "vec4(REVERSED);", "vec4(0u);", stereo_bm_columns),
    mutant("block_match", "around.least ^ REVERSED", "around.least", stereo_bm_columns),
    mutant("block_match", "0u - member * OWN", "member * OWN", |params| {
        stereo_bm_columns(params);
        per_subgroup(params);
    }),
    mutant("prefilter", "abs(y - 1)", "y - 1", stereo_bm),
    mutant("prefilter", "columns == vec4(0)", "columns == vec4(-1)", stereo_bm),
    mutant("prefilter", "(frame.height & 1u) == 1u", "false", stereo_bm),
    mutant("prefilter", "NORMALIZED_EIGHTH) * smoothed", "NORMALIZED_EIGHTH + 1u) * smoothed", |params| {
        stereo_bm(params);
        params.prefilter = Prefilter::Normalized;
    }),
    mutant("texture_columns", "low != last", "low != vec4(1u)", stereo_bm_texture),
    mutant("texture_columns", "abs(row - 1)", "row - 1", stereo_bm_texture),
    mutant("texture_columns", "(last & 1) == 0", "false", stereo_bm_texture),
    mutant("block_match_small", "7u << u32(clamp", "6u << u32(clamp", bm),
    mutant("block_match_small", "if PADDED", "if !PADDED", bm_far),
    mutant("block_match_small", "BLOCK) - start", "BLOCK) - start - 1", bm),
    mutant("block_match_small", "1u) + SLICE", "1u)", bm_far),
    mutant("block_match_small", "x4 - frame.min_disparity", "x4", bm),
    mutant("block_match_small", "k - 1u", "k", bm),
    mutant("block_match_small", "max(before, after)", "after", |params| {
        bm(params);
        equiangular(params);
    }),
    mutant("block_match_small", "i32(keys[own] & 0xffffu)", "i32(keys[own] & 0x7u)", |params| {
        bm(params);
        labels(params);
    }),
    mutant("block_match_small", "0x7f7f7f7fu", "0x7f7f7f7eu", bm),
    mutant("texture_columns", "weight * (here &", "(here &", texture),
    mutant("texture_columns", "let row = clamp(y, 0,", "let row = clamp(y, 1,", texture),
    mutant("texture_columns", "vec4(s.even.yzw, s.after)", "vec4(s.even.yzw, 0u)", texture),
    mutant("texture_columns", "y - r)", "y - r + 1)", texture),
    mutant("texture", ">= vec4(frame.texture)", "> vec4(frame.texture)", texture),
    mutant("texture", "select(values, vec4(left)", "select(values, vec4(0u)", |params| {
        texture(params);
        params.min_disparity = -20;
    }),
    mutant("texture", "(last & 4u) != 0u", "(last & 4u) == 0u", texture),
    mutant("validity", "place >> 4u, row", "(place + 8) >> 4u, row", masked),
    mutant("validity", "(place + 15) >> 4u", "place >> 4u", masked),
    mutant("validity", "has_content(dispatch.own.side, x, row)", "true", masked),
    mutant("validity", "select(-value, value, dispatch.own.side == 1u)", "-value", masked),
    mutant("validity", "1u - dispatch.own.side", "dispatch.own.side", masked),
    mutant("validity", "side * frame.height + row", "row", masked),
    mutant("validity", "column & 31u", "column & 30u", masked),
    mutant("validity", "i32(frame.width) - 1", "i32(frame.width) - 2", masked),
    mutant("validity", "words.z, x + 4", "words.z, x + 2", masked),
    mutant("lr_check", "frame.lr_max_difference", "(frame.lr_max_difference + 1u)", |_| ()),
    mutant("lr_check", "(value + 8)", "value", |_| ()),
    mutant("mirror", "frame.width - 1u - min", "frame.width - min", twice),
    mutant("gray", "16u - left", "17u - left", twice),
    mutant("gray", "unpack(word).wzyx", "unpack(word).wzxy", twice),
    mutant("confidence", "max(margins, vec4(1u))", "margins", |params| {
        bm_pixel(params);
        confidence(params);
        params.uniqueness = 0;
    }),
    mutant("confidence", "frame.map_words / 4u", "0u", confidence),
    mutant("confidence", "vec4(0u), values ==", "vec4(1u), values ==", confidence),
    mutant("rectify", "+ 32768u", "+ 32000u", rectify),
    mutant("rectify", "x < i32(frame.width)", "x < i32(frame.width) - 9", rectify),
    mutant("rectify", "at.x + 1, at.y + 1", "at.x, at.y + 1", rectify),
    mutant("rectify", "position & vec2(255)", "position & vec2(247)", rectify),
    mutant("depth", "depth_low >> (31u - i)", "depth_low >> i", depth),
    mutant("depth", "256 * values", "255 * values", depth),
    mutant("depth", "words.y, 1u)", "words.x, 1u)", depth),
    mutant("depth", "& (values != vec4(INVALID))", "", |params| {
        depth(params);
        params.depth.as_mut().unwrap().doffs = 4096.0;
    }),
    mutant("depth", "near & (divisors", "(divisors", |params| {
        depth(params);
        (params.depth.as_mut().unwrap().focal, params.depth.as_mut().unwrap().baseline) = (1e6, 1000.0);
    }),
    mutant("speckle_rows", "b, joined.z)", "b, joined.y)", speckle),
    mutant("speckle_rows", "vec4(p.before, p.odd.xyz)", "vec4(INVALID, p.odd.xyz)", speckle),
    mutant("speckle_link", "low = first + firstTrailingBit(rest)", "low = first", speckle),
    mutant("speckle_link", "vec4(frame.speckle_range)", "vec4(frame.speckle_range + 40)", speckle),
    mutant("speckle_flatten", "set_tree(at, root)", "set_tree(at, ROOT)", speckle),
    mutant("speckle_count", "1u + firstTrailingBit(~(along >> (start + 1u)))", "1u", speckle),
    mutant("speckle", "<= frame.speckle_window", "< frame.speckle_window", speckle),
    mutant(
        "speckle_flatten",
        "pixel + 2u * frame.map_stride, root",
        "pixel + 2u * frame.map_stride + 1u, root",
        speckle,
    ),
    mutant("speckle", "vec4(2u, 8u, 32u, 128u))", "vec4(2u, 8u, 32u, 64u))", speckle),
    mutant("fill_rows", "last = odd.w", "last = even.w", |params| params.fill = Fill::Background),
    mutant("fill_rows", "odd.y = after(even.z, odd.y)", "odd.y = after(odd.z, odd.y)", rays),
    mutant("fill_lines", "rows.x + n, rows.y - n", "rows.x + n, rows.x + n", rays),
    mutant("fill_lines", "-7 - 8 * group", "1 - 8 * group", rays),
    mutant("fill_lines", "8 * group + 7", "8 * group", rays),
    mutant("fill_lines", "u32(x & 7)", "u32(x & 6)", rays),
    mutant("fill_seen", "(value >> 4u) + frame.fill_max_difference", "(value >> 4u)", rays),
    mutant("fill_seen", "31u - to_bit", "32u - to_bit", rays),
    mutant("fill_between", "select(min(a, b), max(a, b)", "select(max(a, b), max(a, b)", |params| {
        params.fill = Fill::Background
    }),
    mutant("fill_between", "dispatch.own.occlusions == 1u", "false", rays),
    mutant("fill_rays", "(valid - 1u) / 2u", "valid / 2u", rays),
    mutant("fill_rays", "min(valid - 1u, 1u)", "min(valid - 1u, 2u)", |params| {
        rays(params);
        params.fill = Fill::Hirschmuller;
    }),
    mutant("fill_rays", "place(x, y, -1)", "place(x, y, 0)", rays),
    mutant("fill_rows_medians", "vec3(value, before.xy)", "vec3(value, before.yz)", weighted_rays),
    mutant("fill_rows_medians", "select(middle, v.x, middle == INVALID)", "v.x", weighted_rays),
    mutant("fill_rows_medians", "last = after(last, second.z)", "last = after(last, second.y)", weighted_rays),
    mutant("fill_rows_medians", "end - 23", "end - 7", weighted_strips),
    mutant("fill_rows_medians", "max(row, 2u) - 2u", "max(row, 1u) - 1u", weighted_rays),
    mutant("fill_rows_medians", "2u * lower >= pairs", "2u * lower > pairs", weighted_rays),
    mutant("fill_rows_medians", "slope(row, end, !leftwards)", "slope(row, end, leftwards)", weighted_rays),
    mutant("fill_rows_medians", "away + vec4(1)", "away", weighted_rays),
    mutant("fill_rows_medians", "middle - clamp", "middle + clamp", weighted_rays),
    mutant("fill_rows_gray", "last = keys.high.w", "last = keys.high.z", weighted_rays),
    mutant("fill_rows_gray", "row, i + 2u", "row, i + 1u", weighted_rays),
    mutant("fill_rows_gray", "values == vec4(INVALID)", "values < vec4(INVALID)", weighted_rays),
    mutant("fill_lines_gray", "x + 16", "x + 15", weighted_rays),
    mutant("fill_lines_gray", "rows.x + n, rows.y - n", "rows.x + n, rows.x + n", weighted_rays),
    mutant("fill_rays_weighted", "all + vec4(1u)", "all", counted_rays),
    mutant("fill_rays_weighted", "2u * reached >= total", "2u * reached > total", counted_rays),
    mutant("fill_rays_weighted", "a > larger", "a >= larger", weighted_rays),
    mutant("fill_rays_weighted", "place(x, y, -1)", "place(x, y, 0)", weighted_rays),
    mutant("fill_rays_weighted", "j > 3u", "j > 4u", weighted_rays),
    mutant("median", "7) == beyond", "7) == beyond + 9", |_| ()),
    mutant("median", "select(before, even.x, i == 0u)", "before", |params| params.min_disparity = -20),
    mutant("median", "min(y + 1u, frame.height - 1u)", "id.y", |_| ()),
    mutant("median", "(seen >= vec4(0)) & (seen < vec4(i32(frame.width)))", "seen == seen", any),
    mutant("median_five", "beyond + 1", "beyond", five),
    mutant("median_five", "y + 2", "y + 1", five),
    mutant("median_five", "middle.d, min(low[0], high[0])", "middle.c, min(low[0], high[0])", five),
    mutant(
        "median_five",
        "select(vec2(map_value(before, 0u), map_value(before, 1u)), vec2(even.x), i == 0u)",
        "vec2(map_value(before, 0u), map_value(before, 1u))",
        |params| {
            five(params);
            params.min_disparity = -20;
        },
    ),
    mutant("median_five_parallel", "beyond + 1", "beyond", five_parallel),
    mutant("median_five_parallel", "min(i / 2u + 1u, stride - 1u), upper", "i / 2u, upper", five_parallel),
    mutant("median_five_parallel", "vec4(i.c.zw, o.c.zw)", "vec4(i.c.zw, o.c.wz)", five_parallel),
    mutant("weighted_median_parallel", "x / 16u + 1u", "x / 16u", weighted_parallel),
    mutant("weighted_median_parallel", "select(vec2(0u), both, inside)", "both", weighted_parallel),
    mutant("weighted_median_parallel", "middle_one > 0xffffu", "true", weighted_parallel),
    mutant("weighted_median", "2u * reached >= total", "3u * reached >= total", weighted),
    mutant("weighted_median", "512u - (halvings & 255u)", "512u", weighted),
    mutant("weighted_median", "select(i32(frame.width + 8u * AROUND), 0, y == i32(row))", "0", weighted),
    mutant("weighted_median", "0xffffu), (even >= vec4(0))", "0xffffu), (even >= vec4(-8))", weighted),
    mutant("weighted_median", "exchange(keys, 2u, 2u, 6u);", "", weighted),
    mutant("weighted_median", "(i & 1u) == 1u", "(i & 1u) == 0u", weighted),
    mutant("weighted_median", "middle(&keys), valid", "middle(&keys), true", weighted),
    mutant("wls_start", "16 * frame.min_disparity", "16 * frame.min_disparity - 1", wls),
    mutant("wls_start", "disparity == INVALID", "false", wls),
    mutant("wls_forward", "0u, i + 1u == end", "9u, i + 1u == end", wls),
    mutant("wls_forward", "- select(0u, 1u, rest < 0)", "- 1u", wls),
    mutant("wls_forward", "dispatch.shift +", "0u +", wls),
    mutant("wls_forward", "65536u - share", "65535u - share", wls),
    mutant("wls_forward", "+ 16u;", "+ 15u;", wls),
    mutant("wls_backward", "dispatch.rows - 1u - i", "i", wls),
    mutant("wls", "(bits + 1u)", "bits", wls),
    mutant("network_input", "0.456", "0.455", network),
    mutant("network_input", "id.y - padding", "id.y - padding - 1u", network),
    mutant("conv2d", "max(value, vec4(0.0))", "value", network),
    mutant("conv2d", "dispatch.own.flags & 2u", "dispatch.own.flags & 4u", network),
    mutant("conv2d_half", "STRIDE: u32 = 2u", "STRIDE: u32 = 1u", network),
    mutant("conv2d_dilated", "DILATION: u32 = 2u", "DILATION: u32 = 1u", network),
    mutant("conv2d_point", "4u * i + 1u", "4u * i", network),
    mutant("conv2d_point_half", "task.y * STRIDE", "task.y", network),
    mutant("conv3d", "k - DEPTH / 2u", "k", network),
    mutant("conv3d", "dispatch.own.flags & 1u", "dispatch.own.flags & 4u", network),
    mutant("conv3d", "x < dispatch.own.in_columns", "x <= dispatch.own.in_columns", network),
    mutant("conv3d_half", "task.x * STRIDE -", "task.x -", network),
    mutant("conv3d_volume", "x >= z", "x + 1u >= z", network),
    mutant("conv3d_volume", "select(0u, z, right)", "0u", network),
    mutant("conv3d_transposed", "2u - 2u * k", "2u * k", network),
    mutant("conv3d_transposed", "times(at + 8u", "times(at", network),
    mutant("average_pool", "f32(side * side)", "f32(side * side + 1u)", network),
    mutant("upsample", "max(count, 2u) - 1u", "max(count, 2u)", network),
    mutant("upsample", "(2u * to + 1u) * others", "2u * to * others", network_pixels),
    mutant("disparity_regression", "z.low > at", "z.low > at + 1u", network),
    mutant("disparity_regression", "moment / total", "moment", network),
    mutant("round_disparities", ">= 0.5", ">= 0.6", network),
    mutant("feature_histogram", "select(4u * values", "select(3u * values", learned),
    mutant("feature_histogram", "x + i < frame.width", "x + i <= frame.width", learned),
    mutant("feature_statistics", "64u * sum / number", "64u * (sum / number)", learned),
    mutant("feature_statistics", "own[i] * distance * distance", "own[i] * distance", learned),
    mutant("feature_input", "pixels_from(x - 1, y)", "pixels_from(x, y)", learned),
    mutant("feature_input", "quotients(16u *", "quotients(15u *", learned),
    mutant("feature_point", "c > last", "c > last + 1u", learned),
    mutant("feature_point", "4u * step + k", "4u * step", learned),
    mutant("feature_point", "(sums * vec4<i32>(multipliers) + rounding)", "(sums * vec4<i32>(multipliers))", learned),
    mutant("feature_convolution", "step % 3u", "0u", learned),
    mutant("feature_convolution", "row + dy) - 1", "row + dy)", learned),
    mutant("feature_depthwise", "fma(taps[2], line[c + 2u]", "fma(taps[2], line[c + 1u]", learned),
    mutant("feature_depthwise", "select(before, here.x, vector == 0u)", "before", learned),
    mutant("feature_depthwise", "frame.height) - 1)", "frame.height) - 2)", learned),
    mutant("features", "340u *", "338u *", learned),
    mutant("features", "roots * roots < square", "roots < vec4(0u)", learned),
    mutant("features", "select(size, ~size + vec4(1u), v < vec4(0))", "size", learned),
    mutant("matching_cost_features", "vec4(225u)", "vec4(200u)", learned),
    mutant("matching_cost_features", "vector < 0", "vector < -1", learned),
    mutant("matching_cost_features", "dot4I8Packed(a, b)", "dot4I8Packed(a, a)", learned_packed),
    mutant("matching_cost_features", "+ vec4(32u)", "+ vec4(31u)", learned_census),
    mutant("cost_columns_features", "x - frame.min_disparity", "x", learned_blocks),
    mutant("cost_columns_features", "4u * i + 3u", "4u * i + 2u", learned_blocks),
    mutant("round_disparities", "i32(16u * (DISPARITIES - 1u))", "i32(16u * (DISPARITIES / 2u))", network),
];
