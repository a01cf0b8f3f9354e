//! The error of everything that reads and writes files.

use std::error::Error as Cause;
use std::fmt::{self, Display, Formatter};
use std::io::{self, ErrorKind};

/// Why a file cannot be read or written, in one sentence: which file, what is wrong with it, what to do. Options that are
/// named in it are those of the command.
#[derive(Clone, Debug)]
pub struct Error {
    text: String,
    io: Option<(ErrorKind, Option<i32>)>,
}

/// The result of reading or writing a file.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// An error with this text.
    pub(super) fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), io: None }
    }

    /// An error of another library, with its causes.
    pub(super) fn of(error: &(dyn Cause + 'static)) -> Self {
        let mut found = Self::new(error.to_string());
        let mut cause = Some(error);
        while let Some(error) = cause {
            found.io = found.io.or_else(|| match error.downcast_ref::<Self>() {
                Some(own) => own.io,
                None => error.downcast_ref::<io::Error>().map(|error| (error.kind(), error.raw_os_error())),
            });
            cause = error.source();
            if let Some(cause) = cause {
                found.text += &format!(": {cause}");
            }
        }
        found
    }

    /// The same error; its text starts with what was being done.
    pub(super) fn context(self, text: impl Display) -> Self {
        Self { text: format!("{text}: {}", self.text), ..self }
    }

    /// An I/O error as one of this module, for a caller that still needs the original.
    pub fn of_io(error: &io::Error) -> Self {
        Self::of(error)
    }

    /// What the operating system said, such as that there is no such file; `None` if the file was read, and its contents are wrong.
    pub fn io_kind(&self) -> Option<ErrorKind> {
        self.io.map(|(kind, _)| kind)
    }

    /// Whether what cannot be written now cannot be written a moment later either, and nothing else can be: the disk is full,
    /// read-only or lost, or the process has no file left to open.
    pub fn is_lasting(&self) -> bool {
        // EIO, ENFILE, EMFILE
        self.io.is_some_and(|(kind, number)| {
            let of_unix = cfg!(unix) && matches!(number, Some(5 | 23 | 24));
            of_unix
                || matches!(
                    kind,
                    ErrorKind::StorageFull
                        | ErrorKind::QuotaExceeded
                        | ErrorKind::FileTooLarge
                        | ErrorKind::ReadOnlyFilesystem
                        | ErrorKind::StaleNetworkFileHandle
                )
        })
    }
}

impl Display for Error {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Cause for Error {}

impl From<io::Error> for Error {
    fn from(error: io::Error) -> Self {
        Self::of(&error)
    }
}

impl From<crate::Error> for Error {
    fn from(error: crate::Error) -> Self {
        Self::of(&error)
    }
}

/// Adds to an error, or to a missing value, what was being done.
pub(super) trait Context<T> {
    fn context(self, text: impl Display) -> Result<T>;
    fn with_context<D: Display>(self, text: impl FnOnce() -> D) -> Result<T>;
}

impl<T, E: Cause + 'static> Context<T> for Result<T, E> {
    fn context(self, text: impl Display) -> Result<T> {
        self.map_err(|error| Error::of(&error).context(text))
    }

    fn with_context<D: Display>(self, text: impl FnOnce() -> D) -> Result<T> {
        self.map_err(|error| Error::of(&error).context(text()))
    }
}

impl<T> Context<T> for Option<T> {
    fn context(self, text: impl Display) -> Result<T> {
        self.ok_or_else(|| Error::new(text.to_string()))
    }

    fn with_context<D: Display>(self, text: impl FnOnce() -> D) -> Result<T> {
        self.ok_or_else(|| Error::new(text().to_string()))
    }
}

/// An error with a text.
macro_rules! error {
    ($($text:tt)*) => { $crate::files::error::Error::new(format!($($text)*)) };
}

/// Returns an error with a text.
macro_rules! bail {
    ($($text:tt)*) => { return Err($crate::files::error::error!($($text)*)) };
}

/// Returns an error with a text unless the condition holds.
macro_rules! ensure {
    ($condition:expr, $($text:tt)*) => {
        let holds: bool = $condition;
        if !holds {
            $crate::files::error::bail!($($text)*);
        }
    };
}

pub(super) use {bail, ensure, error};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_disk_lasts_and_a_missing_file_does_not() {
        let lasting = |kind: ErrorKind| Error::from(io::Error::from(kind)).context("of a map").is_lasting();
        assert!(
            lasting(ErrorKind::StorageFull) && lasting(ErrorKind::FileTooLarge) && lasting(ErrorKind::QuotaExceeded)
        );
        assert!(!lasting(ErrorKind::NotFound) && !lasting(ErrorKind::PermissionDenied));
        assert!(!Error::new("something else").is_lasting());
        #[cfg(unix)]
        for number in [5, 28, 27, 30, 122] {
            let lasts = Error::from(io::Error::from_raw_os_error(number)).is_lasting();
            assert!(lasts || (number == 122 && !cfg!(target_os = "linux")), "{number}");
        }
    }

    #[test]
    fn a_text_has_all_causes_in_their_order() {
        let inner: Result<()> = Err(io::Error::from_raw_os_error(28)).context("the inner");
        let outer = inner.with_context(|| "the outer").unwrap_err();
        assert!(outer.to_string().starts_with("the outer: the inner: "), "{outer}");
        assert!(outer.is_lasting());
    }
}
