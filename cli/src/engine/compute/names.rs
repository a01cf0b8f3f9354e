//! What computes, by name.

use gpu_stereo::backend::Names;
use serde::{Deserialize, Serialize};

/// The names of the adapter and its driver; `--json` prints them as they are.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct EngineNames {
    /// The adapter's name.
    pub adapter: String,
    /// The graphics interface, `cpu` for the native schedule, or `reference`.
    pub backend: String,
    /// The driver's name and version.
    pub driver: String,
    /// For the native schedule a CPU adapter that is there, too.
    #[serde(skip)]
    pub also: Option<String>,
}

impl From<Names> for EngineNames {
    fn from(Names { adapter, backend, driver, also, .. }: Names) -> Self {
        Self { adapter, backend, driver, also }
    }
}

impl EngineNames {
    /// Adds what has computed a part, too.
    pub fn add(&mut self, other: Self) {
        if self.adapter.is_empty() {
            *self = other;
        } else if !self.adapter.split("; ").any(|adapter| adapter == other.adapter) {
            for (all, one) in [
                (&mut self.adapter, other.adapter),
                (&mut self.backend, other.backend),
                (&mut self.driver, other.driver),
            ] {
                *all = format!("{all}; {one}");
            }
        }
    }
}
