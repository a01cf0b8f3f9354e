//! The rounds that src/gpu/rounds.rs counts, against those that the driver counts. Before its own loops a kernel spends rounds in
//! one that does nothing: as many as lavapipe lets an invocation take, less those that the kernel is said to need. If it needs
//! more, lavapipe leaves its loops early, and the result is wrong. On other drivers nothing is limited, and nothing is shown.

use wgpu::naga::{self, BinaryOperator, Expression, Function, Handle, Module, Statement};

use super::settings::{Setup, depth, five, wls};
use super::specialisations::{PLAN, parse, plans, texts};
use super::support;
use crate::gpu::edits::with_edit;
use crate::gpu::kernels::KERNELS;
use crate::gpu::plan::Plan;
use crate::gpu::rounds::{MOST, MOST_SIDE, rounds};
use crate::network::tiny::tiny;
use crate::{Cost, Fill, Params, Paths, Prefilter, Schedule, Subpixel};

/// The text of a kernel that spends rounds first.
fn spending(spent: u32, text: &str) -> String {
    let main = text.find("fn main(").unwrap();
    let (before, body) = text.split_at(main + text[main..].find("{\n").unwrap() + 2);
    // What is added is 1, but the compiler does not know.
    format!(
        "{before}    var spent = 0u;
    while spent < {spent}u {{
        spent += 1u + (frame.width >> 31u);
    }}
    if spent == 0xffffffffu {{
        return;
    }}
{body}"
    )
}

/// Calls `make` with kernels that leave themselves no more rounds than they are said to need for such images; `kernel` only so
/// many for each hundred of them.
pub(crate) fn with_few_rounds<T>(
    params: &Params,
    size: [u32; 2],
    plan: Plan,
    kernel: Option<(&'static str, u32)>,
    make: impl FnOnce() -> T,
) -> T {
    let params = params.clone();
    let spends = move |name: &str| {
        let needed = rounds(name, &params, size, &plan)?;
        let left = kernel.filter(|(kernel, _)| *kernel == name).map_or(needed, |(_, part)| needed * part / 100);
        Some(MOST - left - 1)
    };
    with_edit(move |name, text| spends(name).map_or(text.clone(), |spent| spending(spent, &text)), make)
}

/// The mismatches with kernels that have few rounds left.
fn mismatches(
    setup: &Setup,
    [width, height]: [u32; 2],
    format: u32,
    params: &Params,
    kernel: Option<(&'static str, u32)>,
) -> Vec<(String, u64)> {
    let (_, device, queue) = setup;
    let (left, right) = support::pair(width, height, 5);
    let (left, right) = (support::as_format(&left, format), support::as_format(&right, format));
    let plan = Plan::new(device, params);
    let matcher = with_few_rounds(params, [width, height], plan, kernel, || {
        support::matcher(device, queue, (width, height), left.format(), params)
    });
    let stages = matcher.unwrap().check_blocking(&left, &right).unwrap();
    stages.into_iter().filter(|stage| stage.mismatches > 0).map(|stage| (stage.stage, stage.mismatches)).collect()
}

fn filters(params: &mut Params) {
    wls(params);
    five(params);
    (params.speckle_window, params.weighted_median, params.texture) = (40, Some(2), 60);
    (params.fill, params.lr_check) = (Fill::Rays, Some(1));
    depth(params);
}

/// Settings that between them take every kernel with loops, at many sizes of its state.
fn cases() -> Vec<(bool, Params)> {
    let sgm = Params::sgm;
    let mut cases = Vec::new();
    for (i, disparities) in (0..).zip([8, 30, 48, 64, 96, 300]) {
        let adaptive = Params { adaptive_p2: true, passes: 2, min_disparity: -3, ..sgm(disparities) };
        cases.push((i % 2 == 1, Params { schedule: Schedule::PerThread, ..adaptive.clone() }));
        if i % 3 == 2 {
            cases.push((i % 2 == 0, Params { schedule: Schedule::PerSubgroup, paths: Paths::Eight, ..adaptive }));
            cases.push((i % 2 == 0, Params { min_disparity: 9, block: 2 * i + 3, ..Params::bm(disparities) }));
        }
    }
    let mut filtered = sgm(40);
    filters(&mut filtered);
    cases.push((false, filtered));
    cases.push((false, Params { fill: Fill::Hirschmuller, block: 51, prefilter: Prefilter::Normalized, ..sgm(20) }));
    cases.push((false, Params { block: 1, fill: Fill::WeightedRays, ..sgm(64) }));
    for (i, disparities) in (0..).zip([8, 40, 96, 130]) {
        let schedule = [Schedule::PerThread, Schedule::PerSubgroup][i / 2 % 2];
        cases.push((i % 2 == 1, Params { bp_levels: 2, bp_iterations: 2, schedule, ..Params::bp(disparities) }));
    }
    cases.push((false, Params { cost: Cost::Census, block: 7, prefilter: Prefilter::None, ..sgm(64) }));
    cases.push((true, Params { cost: Cost::Ncc, block: 19, prefilter: Prefilter::None, ..Params::bm(96) }));
    cases.push((false, Params { cost: Cost::Ncc, block: 3, prefilter: Prefilter::None, ..Params::bm(33) }));
    cases.push((false, Params::psmnet(16, tiny(3))));
    for (cost, block, schedule) in [
        (Cost::Learned, 1, Schedule::PerThread),
        (Cost::LearnedCensus, 1, Schedule::PerSubgroup),
        (Cost::LearnedCensus, 5, Schedule::PerThread),
    ] {
        let features = (block > 1).then(crate::features::tiny);
        cases.push((block > 1, Params { cost, block, schedule, features, prefilter: Prefilter::None, ..sgm(33) }));
    }
    cases
}

#[test]
fn no_kernel_takes_more_rounds_than_are_counted() {
    let (Some(full), Some(bare)) = (support::device(), support::bare_device()) else { return };
    let mut wrong = Vec::new();
    for (i, (on_bare, params)) in cases().into_iter().enumerate() {
        let (confidence, labels) = (i % 3 == 0, i % 2 == 0);
        let subpixel = [Subpixel::Equiangular, Subpixel::Parabola][i % 2];
        for shader_checks in [false, true] {
            let params = Params { shader_checks, confidence, labels, subpixel, ..params.clone() };
            let size = [[97, 5], [131, 3], [61, 9]][i % 3];
            let found = mismatches(if on_bare { &bare } else { &full }, size, i as u32 % 4, &params, None);
            if !found.is_empty() {
                wrong.push(format!("{found:?} at {size:?}, on a device {on_bare} without features, {params:?}"));
            }
        }
    }
    assert!(wrong.is_empty(), "more rounds were needed:\n{}", wrong.join("\n"));
}

/// The test of the test: half of the rounds do not do.
#[test]
fn too_few_rounds_are_noticed() {
    let Some(full) = support::device() else { return };
    if full.0.get_info().device_type != wgpu::DeviceType::Cpu {
        return; // other drivers count no rounds
    }
    let mut filtered = Params { adaptive_p2: true, ..Params::sgm(21) };
    filters(&mut filtered);
    let pixels = Params { block: 1, fill: Fill::WeightedRays, ..Params::sgm(21) };
    let passes = Params { passes: 2, ..Params::sgm(21) };
    let wide = Params { block: 17, ..Params::sgm(21) };
    let columns = Params { block: 17, ..Params::bm(21) };
    for (kernel, params) in [
        ("matching_cost_small", &filtered),
        ("sgm_aggregate", &filtered),
        ("second_cost", &passes),
        ("winner", &filtered),
        ("fill_rows", &filtered),
        ("fill_lines", &filtered),
        ("fill_rows_medians", &pixels),
        ("fill_rows_gray", &pixels),
        ("fill_lines_gray", &pixels),
        ("wls_forward", &filtered),
        ("matching_cost_pixels", &pixels),
        ("matching_cost", &wide),
        ("block_match", &columns),
        ("block_match_small", &Params::bm(21)),
    ] {
        let params = Params { schedule: Schedule::PerThread, ..params.clone() };
        let found = mismatches(&full, [160, 170], 0, &params, Some((kernel, 50)));
        let stage = KERNELS.iter().find(|row| row.name == kernel).unwrap().stage;
        assert!(found.iter().any(|(name, _)| name == stage), "{kernel} did with half of its rounds: {found:?}");
    }
}

/// At the longest sides, with the settings that take most rounds, all kernels stay below the limit, or the pair is refused.
#[test]
fn the_longest_sides_take_no_more_rounds_than_there_are() {
    let longest = MOST_SIDE;
    for disparities in [1, 16, 64, 256, 4095] {
        for base in [Params::sgm(disparities), Params::bm(disparities)] {
            for min_disparity in [-2047, 0, 2047 - disparities as i32] {
                for block in [1, 15, Params::MAX_BLOCK] {
                    let params = Params { min_disparity, block, prefilter_window: 51, ..base.clone() };
                    for plan in plans(&params) {
                        for kernel in KERNELS {
                            let small = ["matching_cost_small", "block_match_small"].contains(&kernel.name);
                            for size in [[longest, 1], [1, longest], [longest, longest]] {
                                let taken = rounds(kernel.name, &params, size, &plan);
                                assert!(small || taken.is_none_or(|taken| taken <= MOST), "{} {taken:?}", kernel.name);
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The rounds of a function's loops if none is unrolled; `None` if one of them is not to a constant.
fn constant(module: &Module, function: &Function, block: &naga::Block) -> Option<u32> {
    let mut sum = 0;
    for statement in block {
        sum += match statement {
            Statement::Block(inner) => constant(module, function, inner)?,
            Statement::If { accept, reject, .. } => {
                constant(module, function, accept)? + constant(module, function, reject)?
            }
            Statement::Switch { cases, .. } => {
                cases.iter().map(|case| constant(module, function, &case.body)).sum::<Option<u32>>()?
            }
            Statement::Call { function, .. } => {
                let callee = &module.functions[*function];
                constant(module, callee, &callee.body)?
            }
            Statement::Loop { body, continuing, .. } => {
                let inner = constant(module, function, body)? + constant(module, function, continuing)?;
                trips(module, function, body)? * (1 + inner) + 1
            }
            _ => 0,
        };
    }
    Some(sum)
}

/// The rounds of a loop that counts a variable up to a constant.
fn trips(module: &Module, function: &Function, body: &naga::Block) -> Option<u32> {
    let value = |e: Handle<Expression>| match &function.expressions[e] {
        Expression::Literal(naga::Literal::U32(value)) => Some(*value),
        Expression::Literal(naga::Literal::I32(value)) => u32::try_from(*value).ok(),
        Expression::Constant(constant) => match &module.global_expressions[module.constants[*constant].init] {
            Expression::Literal(naga::Literal::U32(value)) => Some(*value),
            _ => None,
        },
        _ => None,
    };
    body.iter().find_map(|statement| match statement {
        Statement::If { condition, reject, .. } if matches!(reject.last(), Some(Statement::Break)) => {
            match function.expressions[*condition] {
                Expression::Binary { op: BinaryOperator::Less, right, .. } => value(right),
                _ => None,
            }
        }
        _ => None,
    })
}

/// A kernel that is not counted has only loops to constants.
#[test]
fn every_kernel_with_other_loops_is_counted() {
    for kernel in KERNELS {
        if rounds(kernel.name, &Params::sgm(16), [9, 9], &PLAN).is_some() {
            continue;
        }
        for text in texts(kernel) {
            let module = parse(kernel, text);
            let entry = &module.entry_points[0].function;
            let taken = constant(&module, entry, &entry.body);
            assert!(taken.is_some_and(|taken| taken < MOST / 2), "{} in src/gpu/rounds.rs: {taken:?}", kernel.name);
        }
    }
}
