//! Messages in one line, whatever they quote.

/// The longest message in characters; of a longer one the middle is left out, for what to do stands at the end.
pub const MOST: usize = 2000;

/// The lines of a text in one, without anything that a terminal would obey.
pub fn one_line(text: &str) -> String {
    let joined = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
    let mut line = Vec::new();
    for c in joined.chars() {
        if c.is_control() { line.extend(c.escape_default()) } else { line.push(c) }
    }
    if line.len() > MOST {
        line.splice(MOST / 2..line.len() - MOST / 2 + 4, " .. ".chars());
    }
    line.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

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
        }
    }
}
