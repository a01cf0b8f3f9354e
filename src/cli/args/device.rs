//! `--backend` and `--adapter`: where to compute.

use super::headings::DEVICE;
use clap::ValueEnum;

/// Where to compute.
#[derive(Clone, Debug, clap::Args)]
pub struct DeviceArgs {
    /// auto: the best GPU, else a CPU adapter, else the CPU reference; gpu: any adapter; cpu: the reference
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
    /// The reference in plain Rust
    Cpu,
}
