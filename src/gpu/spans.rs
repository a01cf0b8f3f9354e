//! Spans of the crate `tracing`, with the feature of that name; nothing without.

/// A span from here to the end of the block, of the target `gpu_stereo`: its level, its name, and its fields.
#[cfg(feature = "tracing")]
macro_rules! span {
    ($level:ident, $name:literal $(, $field:ident = $value:expr)*) => {
        let _span = tracing::span!(target: "gpu_stereo", tracing::Level::$level, $name $(, $field = $value)*).entered();
    };
}

#[cfg(not(feature = "tracing"))]
macro_rules! span {
    ($level:ident, $name:literal $(, $field:ident = $value:expr)*) => {
        $(let _ = &$value;)*
    };
}

pub(crate) use span;
