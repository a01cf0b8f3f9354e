//! The words in which a resource of the caller's is refused.

use crate::Error;
use wgpu::TextureFormat;

pub(super) fn refused(
    what: &str,
    given: &dyn std::fmt::Display,
    allowed: &dyn std::fmt::Display,
    remedy: &str,
) -> Error {
    Error::Image(format!("{what} {given}, but {allowed}; {remedy}"))
}

/// A resource that lacks a usage.
pub(super) fn lacks(name: &str, usage: &dyn std::fmt::Debug, needed: &str) -> Error {
    refused(name, &format!("has the usages {usage:?}"), &format!("needs {needed}"), "create it with that usage")
}

/// Formats in words.
pub(super) fn listed(formats: &[TextureFormat]) -> String {
    let names: Vec<String> = formats.iter().map(|format| format!("{format:?}")).collect();
    names.join(" or ")
}
