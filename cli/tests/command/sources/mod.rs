//! What pairs are taken from besides two files: files and videos of both views, stdin, records.

mod both;
mod record;
#[cfg(unix)]
mod stream;
