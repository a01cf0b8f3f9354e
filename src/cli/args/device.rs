//! `--backend` and `--adapter`: where to compute.

use super::headings::DEVICE;
use clap::ValueEnum;

/// Where to compute.
#[derive(Clone, Debug, clap::Args)]
pub struct DeviceArgs {
    /// auto: the best GPU, else the CPU; gpu: any adapter, a CPU adapter such as lavapipe, too; cpu: this program's schedule
    /// for CPUs, without an adapter; reference: the definition, slow
    #[arg(long, value_enum, default_value_t = Backend::Auto, help_heading = DEVICE)]
    pub backend: Backend,

    /// The adapter to use: its index or a part of its name, as --list-adapters shows them
    #[arg(long, value_name = "NAME-OR-INDEX", help_heading = DEVICE)]
    pub adapter: Option<String>,
}

/// `--backend`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// The best one available
    Auto,
    /// Any adapter, a CPU adapter such as lavapipe included
    Gpu,
    /// The native schedule
    Cpu,
    /// The reference in plain Rust
    Reference,
}

impl Backend {
    /// Whether it may compute on an adapter.
    pub fn takes_adapters(self) -> bool {
        matches!(self, Self::Auto | Self::Gpu)
    }

    /// Its name on the command line.
    pub fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }
}
