//! `--backend` and `--adapter`: where to compute.

use super::choices;
use super::headings::DEVICE;
use gpu_stereo::backend::{Backend, Place};

/// Where to compute.
#[derive(Clone, Debug, clap::Args)]
pub struct DeviceArgs {
    /// auto: the best GPU, else the CPU; gpu: any adapter, a CPU adapter such as lavapipe, too; cpu: this program's schedule
    /// for CPUs, without an adapter; reference: the definition, slow
    #[arg(long, value_parser = choices::backend(), value_name = "BACKEND", default_value = "auto", help_heading = DEVICE)]
    pub backend: Backend,

    /// The adapter to use: its index or a part of its name, as --list-adapters shows them
    #[arg(long, value_name = "NAME-OR-INDEX", help_heading = DEVICE)]
    pub adapter: Option<String>,
}

impl DeviceArgs {
    /// Where the options say to compute.
    pub fn place(&self) -> Place {
        Place::new(self.backend, self.adapter.clone())
    }
}
