//! What computes, by name.

/// The names of an adapter and its driver, or of what computes without one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Names {
    /// The adapter's name.
    pub adapter: String,
    /// The graphics interface, `cpu` for the native schedule, or `reference`.
    pub backend: String,
    /// The driver's name and version.
    pub driver: String,
    /// For the native schedule a CPU adapter that is there, too.
    pub also: Option<String>,
}
