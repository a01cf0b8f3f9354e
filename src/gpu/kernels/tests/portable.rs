//! What no kernel may do though lavapipe lets it, because other drivers compute something else or refuse it: barriers that not
//! all invocations of a workgroup reach, signed remainders, shifts by the bits of a word or more, and arrays and structs of
//! one kind where another one of the same shape is declared.

mod barriers;
mod functions;
mod integers;
mod mutants;
mod types;

use std::collections::BTreeSet;
use std::sync::LazyLock;

use barriers::lonely_barriers;
use functions::understood;
use integers::doubtful_integers;
use types::other_types;

use super::specialisations::every_text;

/// Writes every text into the folder that the environment names, for the compilers of tests/portability/run.
#[test]
#[ignore = "writes files: tests/portability/run"]
fn texts_are_written() {
    let folder = std::env::var_os("GPU_STEREO_TEXTS").expect("GPU_STEREO_TEXTS names the folder");
    let texts: BTreeSet<_> = every_text().collect();
    for (nth, (name, text)) in texts.iter().enumerate() {
        let name = format!("{nth:04}-{}.wgsl", name.replace('/', "-"));
        std::fs::write(std::path::Path::new(&folder).join(name), text).expect("the folder takes files");
    }
}

/// What is wrong with the specialised kernels.
#[derive(Default)]
struct Findings {
    barriers: BTreeSet<String>,
    integers: BTreeSet<String>,
    types: BTreeSet<String>,
    /// Texts that have a barrier.
    with_barriers: u32,
}

/// Of all texts, looked at once for all tests.
static FINDINGS: LazyLock<Findings> = LazyLock::new(|| {
    let mut findings = Findings::default();
    for (name, text) in every_text() {
        let (module, info) = understood(text).unwrap_or_else(|error| panic!("{name}.wgsl: {error}"));
        let named = |wrong: Vec<String>| wrong.into_iter().map(move |wrong| format!("{name}.wgsl, {wrong}"));
        findings.barriers.extend(named(lonely_barriers(&module)));
        findings.integers.extend(named(doubtful_integers(&module, &info)));
        findings.types.extend(named(other_types(&module, &info)));
        findings.with_barriers += u32::from(text.contains("workgroupBarrier()"));
    }
    findings
});

#[test]
fn all_invocations_reach_each_barrier() {
    let Findings { barriers, with_barriers, .. } = &*FINDINGS;
    assert!(barriers.is_empty(), "where not all invocations of a workgroup come: {barriers:#?}");
    assert!(*with_barriers > 10, "only {with_barriers} texts have barriers");
}

#[test]
fn integers_mean_the_same_on_every_driver() {
    let wrong = &FINDINGS.integers;
    assert!(wrong.is_empty(), "take unsigned numbers, and shifts below their bits: {wrong:#?}");
}

#[test]
fn values_have_the_types_that_are_declared() {
    let wrong = &FINDINGS.types;
    assert!(wrong.is_empty(), "construct the declared type by its name: {wrong:#?}");
}
