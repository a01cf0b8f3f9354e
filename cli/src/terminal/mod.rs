//! Everything that the command prints: data on stdout, messages on stderr. Control characters are escaped wherever they come from:
//! names of files and adapters, contents of files, messages of libraries.

mod json;
mod pace;
mod print;
mod progress;
mod scores;
mod share;
mod table;
mod text;
pub mod warnings;

pub use json::{json, paths, pretty_json, rounded, to_microseconds};
pub use pace::Pace;
pub use print::{message, print, print_json};
pub use progress::Progress;
pub use scores::{Evaluation, percent, pixels};
pub use share::{Share, watched};
pub use table::table;
#[cfg(test)]
pub use text::must_be_escaped;
pub use text::{name, one_line, plain};
