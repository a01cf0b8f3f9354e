//! Numbers as they were typed.

use anyhow::{Context as _, Result, bail};
use std::str::FromStr;
use std::thread;

/// A whole number with its text. Numbers beyond an `i64` saturate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Whole {
    /// As it was typed.
    pub text: String,
    /// Its value.
    pub value: i64,
}

impl FromStr for Whole {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (negative, digits) = match text.strip_prefix('-') {
            Some(digits) => (true, digits),
            None => (false, text.strip_prefix('+').unwrap_or(text)),
        };
        if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
            return Err("a whole number is needed, such as 64".into());
        }
        let beyond = if negative { i64::MIN } else { i64::MAX };
        Ok(Self { text: text.into(), value: text.parse().unwrap_or(beyond) })
    }
}

/// A number above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Positive(pub f64);

impl FromStr for Positive {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = text.parse().ok().filter(|number: &f64| *number > 0.0 && number.is_finite());
        number.map(Self).ok_or_else(|| "a number above 0 is needed, such as 16".into())
    }
}

/// Columns and rows, such as 1280x720.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let sides =
        text.split_once(['x', 'X']).and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    let sides = sides.filter(|sides: &[u32; 2]| sides.iter().all(|side| (1..=65_536).contains(side)));
    sides.ok_or_else(|| "columns and rows from 1 to 65536 are needed, such as 1280x720".into())
}

/// Two whole numbers, such as 0,1.
pub fn two(text: &str) -> Result<[u32; 2], String> {
    let two =
        text.split_once(',').and_then(|(one, other)| Some([one.trim().parse().ok()?, other.trim().parse().ok()?]));
    two.ok_or_else(|| "two whole numbers are needed, such as 0,1".into())
}

/// Column and row of the upper left pixel of a part of images, its columns and its rows, such as 100,50,640,480.
pub fn part(text: &str) -> Result<[u32; 4], String> {
    let numbers: Vec<u32> = text.split(',').map_while(|number| number.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y, width @ (1..), height @ (1..)] if text.matches(',').count() == 3 => Ok([x, y, width, height]),
        _ => {
            Err("four whole numbers are needed, the upper left pixel and the size of the part, such as 100,50,640,480"
                .into())
        }
    }
}

const MAX_REPEAT: u32 = 1_000_000;

/// `--repeat`: the frames after the warm-up.
pub fn repeat(given: &Whole) -> Result<u32> {
    match u32::try_from(given.value) {
        Ok(frames @ 1..=MAX_REPEAT) => Ok(frames),
        _ => bail!("--repeat is {}, but must be from 1 to {MAX_REPEAT}; 20 is usual", given.text),
    }
}

const MAX_IN_FLIGHT: usize = 16;

/// `--in-flight`: the pairs on the device at a time.
pub fn in_flight(given: &Whole) -> Result<usize> {
    let in_flight = usize::try_from(given.value).ok().filter(|pairs| (1..=MAX_IN_FLIGHT).contains(pairs));
    in_flight
        .with_context(|| format!("--in-flight is {}, but must be from 1 to {MAX_IN_FLIGHT}; 3 is usual", given.text))
}

const MAX_THREADS: usize = 64;

/// `--threads`: threads that read, and as many that write.
pub fn threads(given: &Whole) -> Result<usize> {
    let threads = usize::try_from(given.value).ok().filter(|threads| (1..=MAX_THREADS).contains(threads));
    threads.with_context(|| {
        format!("--threads is {}, but must be from 1 to {MAX_THREADS}; half of the cores is usual", given.text)
    })
}

/// Half of the cores, at most 8.
pub fn usual_threads() -> usize {
    (thread::available_parallelism().map_or(1, usize::from) / 2).clamp(1, 8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_saturate_and_nothing_else_passes() {
        let value = |text: &str| text.parse::<Whole>().map(|whole| whole.value);
        assert_eq!(value("64"), Ok(64));
        assert_eq!(value("-5"), Ok(-5));
        assert_eq!(value("99999999999999999999999"), Ok(i64::MAX));
        assert_eq!(value("-99999999999999999999999"), Ok(i64::MIN));
        for text in ["", "-", "+", "nan", "1.5", "0x10", "1e3", " 1", "٣", "--1"] {
            assert!(value(text).is_err(), "{text:?}");
        }
    }
}
