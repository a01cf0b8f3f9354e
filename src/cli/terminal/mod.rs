//! All that the command prints. Data goes to stdout, messages go to stderr, and nothing that a terminal would obey passes: not
//! from the name of a file or of an adapter, not from the text of a file, not from a library's words.

mod json;
mod pace;
mod print;
mod progress;
mod scores;
mod table;
mod text;
pub mod warnings;

pub use json::{json, paths, pretty_json, rounded, to_microseconds};
pub use pace::Pace;
pub use print::{message, print, print_json};
pub use progress::Progress;
pub use scores::{Evaluation, percent, pixels};
pub use table::table;
#[cfg(test)]
pub use text::is_obeyed;
pub use text::{name, one_line, plain};
