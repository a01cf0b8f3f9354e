//! Text from anywhere becomes text that is safe to print: control characters are escaped.

use std::ffi::OsStr;
use std::fmt::{self, Debug, Display, Formatter, Write as _};

/// The longest message in characters; longer ones lose their middle, since the remedy stands at the end.
pub const MOST: usize = 2000;

/// Whether a character must be escaped: control characters (C0, DEL, C1), ends of lines and paragraphs, marks of direction, and
/// characters of no width.
pub fn must_be_escaped(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}

/// A character as it may be shown.
fn show(c: char, f: &mut impl fmt::Write) -> fmt::Result {
    match must_be_escaped(c) {
        true => write!(f, "{}", c.escape_default()),
        false => f.write_char(c),
    }
}

/// The name of a file, an adapter or anything else that others chose, for a message or a table. All names are printed this way:
/// control characters are escaped (`\n`, `\u{1b}`), and so are bytes that are not Unicode (`\xFF`).
///
/// `{:?}` is in quotes always, `{}` only where it would not stand out without them.
pub fn name<N: AsRef<OsStr> + ?Sized>(name: &N) -> Name<'_> {
    Name(name.as_ref())
}

/// What [`name`] prints.
#[derive(Clone, Copy)]
pub struct Name<'a>(&'a OsStr);

impl Debug for Name<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_char('"')?;
        for chunk in self.0.as_encoded_bytes().utf8_chunks() {
            for c in chunk.valid().chars() {
                match c {
                    '"' | '\\' => write!(f, "\\{c}")?,
                    c => show(c, f)?,
                }
            }
            chunk.invalid().iter().try_for_each(|byte| write!(f, "\\x{byte:02X}"))?;
        }
        f.write_char('"')
    }
}

impl Display for Name<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let stands_out = |c: char| {
            !(must_be_escaped(c) || c.is_whitespace() || "\"',;:".contains(c) || (c == '\\' && !cfg!(windows)))
        };
        match self.0.to_str() {
            Some(text) if !text.is_empty() && text.chars().all(stands_out) => f.write_str(text),
            _ => Debug::fmt(self, f),
        }
    }
}

/// A text with its control characters escaped.
pub fn plain(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        let _ = show(c, &mut shown); // a string takes all
    }
    shown
}

/// A text in one line, with its control characters escaped.
pub fn one_line(text: &str) -> String {
    let lines = text.split(['\n', '\r', '\u{b}', '\u{c}', '\u{85}', '\u{2028}', '\u{2029}']);
    let line = plain(&lines.map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" "));
    let mut line: Vec<char> = line.chars().collect();
    if line.len() > MOST {
        line.splice(MOST / 2..line.len() - MOST / 2 + 4, " .. ".chars());
    }
    line.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some of every kind.
    const ESCAPED: [char; 22] = [
        '\0', '\u{7}', '\u{8}', '\t', '\n', '\r', '\u{1b}', '\u{1f}', '\u{7f}', '\u{80}', '\u{85}', '\u{9b}', '\u{9f}',
        '\u{ad}', '\u{200b}', '\u{200f}', '\u{2028}', '\u{2029}', '\u{202e}', '\u{2066}', '\u{2069}', '\u{feff}',
    ];

    #[test]
    fn what_is_quoted_stays_in_the_line() {
        assert_eq!(one_line("a\n\n  b\r\nc"), "a b c");
        assert_eq!(one_line("\u{1b}[2J ä\0\u{9b}"), "\\u{1b}[2J ä\\u{0}\\u{9b}");
        let of = |length: usize| one_line(&format!("b{}e", "ä".repeat(length - 2)));
        assert_eq!(of(MOST).chars().count(), MOST);
        for length in [MOST + 1, MOST + 5, 10 * MOST] {
            let line = of(length);
            assert_eq!(line.chars().count(), MOST);
            assert!(line.starts_with("bä") && line.contains("ä .. ä") && line.ends_with("äe"));
            assert_eq!(one_line(&line), line);
        }
    }

    #[test]
    fn control_characters_are_escaped() {
        for c in ESCAPED {
            let text = format!("a{c}b");
            let escaped = format!("a{}b", c.escape_default());
            assert_eq!(
                (plain(&text), format!("{}", name(&text))),
                (escaped.clone(), format!("\"{escaped}\"")),
                "{c:?}"
            );
            for shown in [plain(&text), one_line(&text), format!("{}", name(&text)), format!("{:?}", name(&text))] {
                assert!(!shown.contains(must_be_escaped), "{c:?} in {shown:?}");
            }
        }
        for c in (0..=0x10_ffff).filter_map(char::from_u32).filter(|c| c.is_control()) {
            assert!(must_be_escaped(c), "{c:?}");
        }
        for letters in ["Straße 立体", "a\u{308}", "👍🏽", "नमस्ते", "עברית"] {
            assert_eq!(plain(letters), letters);
        }
    }

    #[test]
    fn names_are_told_apart() {
        let shown = |text: &str| (format!("{}", name(text)), format!("{:?}", name(text)));
        assert_eq!(shown("a/b-1.png"), ("a/b-1.png".into(), "\"a/b-1.png\"".into()));
        for text in ["a b", "a,b", "a\"b", "", "a;b", "'a'", "a: b", "a\u{a0}b"] {
            let quoted = format!("\"{}\"", text.replace('"', "\\\""));
            assert_eq!(shown(text), (quoted.clone(), quoted));
        }
        assert_eq!(shown("a\nb").1, "\"a\\nb\"");
        assert_eq!(shown("a\\nb").1, "\"a\\\\nb\"");
        #[cfg(unix)]
        {
            use std::os::unix::ffi::OsStrExt as _;
            assert_eq!(format!("{}", name(OsStr::from_bytes(b"a\xff\xc3"))), "\"a\\xFF\\xC3\"");
            assert_eq!(shown("a\\xff").0, "\"a\\\\xff\"");
        }
    }
}
