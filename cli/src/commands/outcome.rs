//! How a verb that could run ended.

/// The answer of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All was done.
    Done,
    /// A check found a mismatch, or a pair, frame or scene failed; it was reported.
    Failed,
}

impl Outcome {
    /// Failed if `failed`.
    pub fn failed_if(failed: bool) -> Self {
        if failed { Self::Failed } else { Self::Done }
    }
}
