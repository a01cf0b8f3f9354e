//! The test of the tests: a wrong shader is found, in the stage that it is in.

mod table;

use table::{MUTANTS, Mutant};

use super::settings::Setup;
use super::support;
use crate::Params;
use crate::PixelFormat;
use crate::gpu::edits::with_mutant;
use crate::gpu::kernels::{KERNELS, source};
use crate::gpu::plan::Plan;

/// The check finds each mutant, and in the stage that it is in: the stages before stay exact.
#[test]
fn a_mutated_shader_is_caught() {
    let (Some(full), Some(bare)) = (support::device(), support::bare_device()) else { return };
    let (width, height, seed) = (93, 41, 5);
    let (left, right) = support::pair(width, height, seed);
    let mut wrong = Vec::new();
    for Mutant { kernel, from, to, change } in MUTANTS {
        let case = format!("{kernel} with {to:?} for {from:?}, seed {seed}, on {}", full.0.get_info().name);
        let row = KERNELS.iter().find(|row| row.name == *kernel).unwrap_or_else(|| panic!("no kernel for {case}"));
        let mut params = Params { min_disparity: -2, ..Params::sgm(21) };
        change(&mut params);
        // A rule that only a device without features follows is broken there.
        let has_it = |(_, device, _): &&Setup| {
            source(row, &params, PixelFormat::Rgba8, &Plan::new(device, &params)).contains(from)
        };
        let setup = [&full, &bare].into_iter().find(has_it);
        let Some((_, device, queue)) = setup else {
            wrong.push(format!("{case}: that is no longer in the text, break the same rule in its new words"));
            continue;
        };

        let format = if *kernel == "deep_gray" { 3 } else { 2 };
        let (left, right) = (support::as_format(&left, format), support::as_format(&right, format));
        let make = || support::matcher(device, queue, (width, height), left.format(), &params);
        let matcher = with_mutant([kernel, from, to], make);
        let stages = matcher.unwrap().check_blocking(&left, &right).unwrap();
        let at = stages.iter().position(|stage| stage.stage == row.stage);
        let Some(at) = at else {
            wrong.push(format!("{case}: not run"));
            continue;
        };
        let before: u64 = stages[..at].iter().map(|stage| stage.mismatches).sum();
        if stages[at].mismatches == 0 || before > 0 {
            wrong.push(format!("{case}: {} mismatches there, {before} in the stages before", stages[at].mismatches));
        }
    }
    assert!(wrong.is_empty(), "not caught, or blamed on another stage:\n{}", wrong.join("\n"));
    let without: Vec<_> = KERNELS.iter().filter(|row| MUTANTS.iter().all(|m| m.kernel != row.name)).collect();
    assert!(without.is_empty(), "no mutant of {without:?}");
}
