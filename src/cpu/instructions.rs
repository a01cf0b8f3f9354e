//! The instruction set that the native schedule is compiled for, chosen at run time.
//!
//! The code is plain Rust in the form that the compiler vectorises, and is compiled once for each set. The crate
//! `fearless_simd` tells which sets the machine has and compiles a function for each of them.

use fearless_simd::{Level, Simd};

use crate::Error;

/// The environment variable that chooses the set: one of the words of [`Instructions::word`].
pub const VARIABLE: &str = "GPU_STEREO_INSTRUCTIONS";

/// The vectors of what the program is compiled for.
#[cfg(target_arch = "x86_64")]
type Base = fearless_simd::Sse2;
#[cfg(target_arch = "aarch64")]
type Base = fearless_simd::Neon;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
type Base = fearless_simd::WasmSimd128;
#[cfg(not(any(
    target_arch = "x86_64",
    target_arch = "aarch64",
    all(target_arch = "wasm32", target_feature = "simd128")
)))]
type Base = fearless_simd::Fallback;

/// Code that is written once, with vectors of the crate `fearless_simd`, for every set.
pub trait Kernel {
    /// What it returns.
    type Output;

    /// Runs it with the vectors of a set. Implement it with `#[inline(always)]`.
    fn run<V: Simd>(self, simd: V) -> Self::Output;
}

/// An instruction set that this machine has.
#[derive(Clone, Copy, Debug)]
pub struct Instructions {
    set: Set,
}

#[derive(Clone, Copy, Debug)]
enum Set {
    /// What the program is compiled for: on x86-64 SSE2, in a browser vectors of 128 bits or none.
    Plain(Base),
    #[cfg(target_arch = "x86_64")]
    Avx2(fearless_simd::Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(fearless_simd::Avx512),
    #[cfg(target_arch = "aarch64")]
    Neon(fearless_simd::Neon),
}

impl Instructions {
    /// The best set of this machine, or the one that the environment variable GPU_STEREO_INSTRUCTIONS asks for: `plain`,
    /// `avx2`, `avx512` or `neon`.
    ///
    /// # Errors
    /// [`Error::Parameter`] if the variable asks for a set that is unknown or that this machine lacks.
    pub fn best() -> Result<Self, Error> {
        Self::asked_for(std::env::var_os(VARIABLE).map(|word| word.to_string_lossy().into_owned()).as_deref())
    }

    /// The set of this name, or without a name the best one.
    fn asked_for(word: Option<&str>) -> Result<Self, Error> {
        let all = Self::all();
        match word.filter(|word| !word.is_empty()) {
            None => Ok(all[all.len() - 1]),
            Some(word) => all.iter().copied().find(|set| set.word() == word).ok_or_else(|| Error::Parameter {
                name: VARIABLE,
                given: word.into(),
                allowed: all.iter().map(|set| set.word()).collect::<Vec<_>>().join(" or ") + " on this machine",
                remedy: "unset the variable to take the best one",
            }),
        }
    }

    /// All sets of this machine, the best one last.
    pub fn all() -> Vec<Self> {
        let sets = [
            base(),
            #[cfg(target_arch = "x86_64")]
            Level::new().as_avx2().map(Set::Avx2),
            #[cfg(target_arch = "x86_64")]
            Level::new().as_avx512().map(Set::Avx512),
            #[cfg(target_arch = "aarch64")]
            Level::new().as_neon().map(Set::Neon),
        ];
        sets.into_iter().flatten().map(|set| Self { set }).collect()
    }

    /// Its name in prose.
    pub fn name(self) -> &'static str {
        match self.set {
            Set::Plain(_) => "plain",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2(_) => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512(_) => "AVX-512",
            #[cfg(target_arch = "aarch64")]
            Set::Neon(_) => "NEON",
        }
    }

    /// Its name in the environment variable.
    fn word(self) -> &'static str {
        match self.set {
            Set::Plain(_) => "plain",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512(_) => "avx512",
            #[cfg(target_arch = "aarch64")]
            Set::Neon(_) => "neon",
        }
    }

    /// Calls `f`, compiled for this set as far as it is inlined: give a closure with `#[inline(always)]` that calls functions
    /// with `#[inline(always)]`.
    #[inline(always)]
    pub fn run<R>(self, f: impl FnOnce() -> R) -> R {
        match self.set {
            Set::Plain(_) => f(),
            #[cfg(target_arch = "x86_64")]
            Set::Avx2(set) => set.vectorize(f),
            #[cfg(target_arch = "x86_64")]
            Set::Avx512(set) => set.vectorize(f),
            #[cfg(target_arch = "aarch64")]
            Set::Neon(set) => set.vectorize(f),
        }
    }

    /// Runs a kernel, compiled for this set.
    #[inline(always)]
    pub fn launch<K: Kernel>(self, kernel: K) -> K::Output {
        match self.set {
            Set::Plain(set) => set.vectorize(
                #[inline(always)]
                || kernel.run(set),
            ),
            #[cfg(target_arch = "x86_64")]
            Set::Avx2(set) => set.vectorize(
                #[inline(always)]
                || kernel.run(set),
            ),
            #[cfg(target_arch = "x86_64")]
            Set::Avx512(set) => set.vectorize(
                #[inline(always)]
                || kernel.run(set),
            ),
            #[cfg(target_arch = "aarch64")]
            Set::Neon(set) => set.vectorize(
                #[inline(always)]
                || kernel.run(set),
            ),
        }
    }
}

/// What the program is compiled for.
fn base() -> Option<Set> {
    #[cfg(target_arch = "x86_64")]
    return Level::baseline().as_sse2().map(Set::Plain);
    #[cfg(target_arch = "aarch64")]
    return Level::baseline().as_neon().map(Set::Plain);
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    return Level::baseline().as_wasm_simd128().map(Set::Plain);
    #[cfg(not(any(
        target_arch = "x86_64",
        target_arch = "aarch64",
        all(target_arch = "wasm32", target_feature = "simd128")
    )))]
    return Some(Set::Plain(fearless_simd::Fallback::new()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_set_computes_the_same() {
        let values: Vec<u8> = (0..1000u32).map(|i| ((i * i * 7) >> 3) as u8).collect();
        let expected: u32 = values.iter().map(|v| v.count_ones()).sum();
        let all = Instructions::all();
        for set in &all {
            let bits = set.run(
                #[inline(always)]
                || values.iter().map(|v| v.count_ones()).sum::<u32>(),
            );
            assert_eq!(bits, expected, "{}", set.name());
        }
        assert_eq!(all[0].name(), "plain");
        assert_eq!(Instructions::asked_for(None).unwrap().name(), all[all.len() - 1].name());
        assert_eq!(Instructions::asked_for(Some("")).unwrap().name(), all[all.len() - 1].name());
    }

    #[test]
    fn a_set_is_chosen_by_its_word() {
        for set in Instructions::all() {
            assert_eq!(Instructions::asked_for(Some(set.word())).unwrap().name(), set.name());
        }
        // A machine has only one family.
        let lacking = if cfg!(target_arch = "aarch64") { "avx2" } else { "neon" };
        for word in [lacking, "AVX2", "sse9"] {
            let error = Instructions::asked_for(Some(word)).unwrap_err().to_string();
            let expected = format!("GPU_STEREO_INSTRUCTIONS is {word}, but must be plain");
            assert!(error.starts_with(&expected), "{error}");
            assert!(error.ends_with("on this machine; unset the variable to take the best one"), "{error}");
        }
    }
}
