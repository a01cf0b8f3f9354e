//! Folders, printf patterns and globs become pairs of files.

use super::pair::Pair;
use crate::terminal::message;
use anyhow::{Context as _, Result, bail, ensure};
use gpu_stereo::files::images::has_image_ending;
use std::collections::{BTreeSet, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

/// The pairs of two sides, each with its number: that of its file if LEFT is a pattern, else counted from 0.
pub fn find(left: &Path, right: &Path) -> Result<Vec<(u64, Pair)>> {
    let (left, right) = (Side::find("LEFT", left)?, Side::find("RIGHT", right)?);
    ensure_in_step(&left, &right)?;
    for side in [&left, &right] {
        side.gap.iter().for_each(|gap| message(gap));
    }
    let pairs = left.paths.into_iter().zip(right.paths).map(|(left, right)| Pair { left, right });
    Ok((left.first..).zip(pairs).collect())
}

/// The pairs of one folder, pattern or glob, whose images hold both views each; numbered as by [`find`].
pub fn find_in_one(given: &Path) -> Result<Vec<(u64, Pair)>> {
    let side = Side::find("the name", given)?;
    side.gap.iter().for_each(|gap| message(gap));
    Ok((side.first..).zip(side.paths.iter().map(|path| Pair::in_one(path))).collect())
}

/// The frames of one camera.
struct Side {
    /// As it was typed.
    given: PathBuf,
    paths: Vec<PathBuf>,
    /// The number of the first one.
    first: u64,
    /// The message on frames after a gap.
    gap: Option<String>,
}

impl Side {
    /// The frames that `given` means, in order; at least one.
    fn find(name: &str, given: &Path) -> Result<Self> {
        let side = |paths| Self { given: given.into(), paths, first: 0, gap: None };
        if given.is_dir() {
            let paths = images(given).with_context(|| format!("{name} is {given:?}, a folder that cannot be read"))?;
            ensure!(
                !paths.is_empty(),
                "{name} is {given:?}, a folder without images; give one with PNG, JPEG or other images"
            );
            return Ok(side(paths));
        }
        // An existing file is no pattern, whatever characters its name has.
        if given.is_file() {
            return Ok(side(vec![given.into()]));
        }
        if let Some(pattern) = Pattern::parse(given).with_context(|| format!("{name} is {given:?}"))? {
            return numbered(name, given, &pattern);
        }
        let text = glob_of(given).with_context(|| format!("{name} is {given:?}, but a glob must be Unicode"))?;
        let matches = glob::glob(&text).with_context(|| {
            format!(
                "{name} is {given:?}, which is not a glob; write [[] for [, and ** as a part of the path of its own"
            )
        })?;
        let mut paths = matches
            .filter(|path| path.as_ref().map_or(true, |path| path.is_file()))
            .collect::<Result<Vec<_>, _>>()
            .with_context(|| format!("{name} is {given:?}, but a folder cannot be read"))?;
        ensure!(
            !paths.is_empty(),
            "{name} is {given:?}, but there is neither such a folder nor a file that this matches{}; give a folder, a \
             printf pattern such as img_%06d.png or a glob such as 'left/*.png'{}",
            matched_so_far(given),
            if text.contains('[') { ", in which [[] is written for [".into() } else { gpu_stereo::files::hint(given) }
        );
        sort(&mut paths);
        Ok(side(paths))
    }
}

/// The leading folders of a glob that exist literally, and the rest.
fn literal_folders(given: &Path) -> (PathBuf, PathBuf) {
    let parts: Vec<_> = given.components().collect();
    let there = |count: &usize| parts[..*count].iter().collect::<PathBuf>().is_dir();
    let count = (1..parts.len()).take_while(there).last().unwrap_or(0);
    (parts[..count].iter().collect(), parts[count..].iter().collect())
}

/// A glob whose leading folders are escaped if they exist literally.
fn glob_of(given: &Path) -> Option<String> {
    let (folder, rest) = literal_folders(given);
    let escaped = PathBuf::from(glob::Pattern::escape(folder.to_str()?));
    escaped.join(rest).to_str().map(Into::into)
}

/// How far a glob without matches leads, for its error.
fn matched_so_far(given: &Path) -> String {
    let (folder, rest) = literal_folders(given);
    let mut parts = rest.components();
    if let (Some(next), Some(_)) = (parts.next(), parts.next())
        && !next.as_os_str().to_string_lossy().contains(['*', '?', '['])
    {
        return format!(": there is no folder {:?}", folder.join(next));
    }
    let here = if folder == Path::new("") { Path::new(".") } else { &folder };
    let Ok(entries) = fs::read_dir(here) else { return String::new() };
    let first = entries.flatten().map(|entry| entry.file_name()).min();
    match first {
        Some(first) if folder != Path::new("") => {
            format!(": the folder {folder:?} has {first:?}, for example, but nothing like {rest:?}")
        }
        None if folder != Path::new("") => format!(": the folder {folder:?} is empty"),
        _ => String::new(),
    }
}

/// The images of a folder, by their endings, without hidden files.
fn images(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let hidden = entry.file_name().to_string_lossy().starts_with('.');
        if has_image_ending(&entry.path()) && !hidden && entry.path().is_file() {
            paths.push(entry.path());
        }
    }
    sort(&mut paths);
    Ok(paths)
}

/// Natural order: numbers by their value.
fn sort(paths: &mut [PathBuf]) {
    paths.sort_by(|a, b| alphanumeric_sort::compare_path(a, b).then_with(|| a.cmp(b)));
}

/// The files of a pattern from the first number that exists up to a gap.
fn numbered(name: &str, given: &Path, pattern: &Pattern) -> Result<Side> {
    let folder = pattern.folder();
    let entries = fs::read_dir(folder)
        .with_context(|| format!("{name} is {given:?}, but the folder {folder:?} cannot be read; give another path"))?;
    let mut numbers = BTreeSet::new();
    for entry in entries {
        let entry = entry.with_context(|| format!("the folder {folder:?} cannot be read"))?;
        numbers.extend(entry.file_name().to_str().and_then(|name| pattern.number(name)));
    }
    let Some(&first) = numbers.first() else {
        bail!(
            "{name} is {given:?}, but no file has such a name; the first would be, for example, {:?}",
            pattern.path(0)
        );
    };
    let frames = (first..).take_while(|number| numbers.contains(number)).count() as u64;
    let later = numbers.len() as u64 - frames;
    let gap = (later > 0).then(|| {
        format!("note: there is no {:?}, so the {later} frames after it are skipped", pattern.path(first + frames))
    });
    let paths = (first..first + frames).map(|number| pattern.path(number)).collect();
    Ok(Side { given: given.into(), paths, first, gap })
}

/// A path with a number in its name, `%d` or `%06d`.
#[derive(Debug, PartialEq, Eq)]
pub struct Pattern {
    folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

impl Pattern {
    /// `None` where there is no `%`; `%%` stands for one.
    pub fn parse(path: &Path) -> Result<Option<Self>> {
        if !path.to_string_lossy().contains('%') {
            return Ok(None);
        }
        const ALLOWED: &str =
            "a pattern has one number, %d or such as %06d, and that in the file's name; %% stands for a percent sign";
        let name = path.file_name().and_then(|name| name.to_str()).context(ALLOWED)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let folder = literal(folder).context(ALLOWED)?;
        if !name.contains('%') {
            return Ok(None);
        }
        let (mut texts, mut digits) = (vec![String::new()], 0);
        let mut rest = name;
        while let Some((before, after)) = rest.split_once('%') {
            texts.last_mut().context(ALLOWED)?.push_str(before);
            if let Some(after) = after.strip_prefix('%') {
                texts.last_mut().context(ALLOWED)?.push('%');
                rest = after;
                continue;
            }
            let (width, after) = after.split_once('d').context(ALLOWED)?;
            digits = match width {
                "" => 0,
                _ => width.strip_prefix('0').and_then(|digits| digits.parse().ok()).context(ALLOWED)?,
            };
            ensure!(digits <= 18, "a number has at most 18 digits");
            texts.push(String::new());
            rest = after;
        }
        texts.last_mut().context(ALLOWED)?.push_str(rest);
        match <[String; 2]>::try_from(texts) {
            Ok([before, after]) => Ok(Some(Self { folder, before, digits, after })),
            Err(_) => bail!(ALLOWED),
        }
    }

    /// The folder of its files.
    pub fn folder(&self) -> &Path {
        if self.folder == Path::new("") { Path::new(".") } else { &self.folder }
    }

    /// The path with a number.
    pub fn path(&self, number: u64) -> PathBuf {
        let Self { folder, before, digits, after } = self;
        folder.join(format!("{before}{number:0digits$}{after}"))
    }

    /// The number in a name, if it is written as [`Pattern::path`] writes it.
    fn number(&self, name: &str) -> Option<u64> {
        let digits = name.strip_prefix(&self.before)?.strip_suffix(&self.after)?;
        let number = digits.parse().ok().filter(|&number| number < u64::MAX)?;
        (self.path(number).file_name()? == name).then_some(number)
    }
}

/// A folder with `%` in its path: taken literally if it exists, else with `%%` for `%`.
fn literal(folder: &Path) -> Option<PathBuf> {
    let text = folder.to_string_lossy();
    if !text.contains('%') || folder.is_dir() {
        return Some(folder.into());
    }
    let plain = PathBuf::from(text.replace("%%", "%"));
    (!text.replace("%%", "").contains('%') && plain.is_dir()).then_some(plain)
}

/// Refuses sides with different numbers of frames, and frames that would get another's partner.
fn ensure_in_step(left: &Side, right: &Side) -> Result<()> {
    let (left_keys, right_keys) = (keys(&left.paths), keys(&right.paths));
    let place_of = |keys: &[Vec<String>]| -> HashMap<_, _> { keys.iter().cloned().zip(0_usize..).collect() };
    let sides = [(left, &left_keys), (right, &right_keys)];
    let [few, many] = if left.paths.len() < right.paths.len() { sides } else { [sides[1], sides[0]] };
    let count = few.0.paths.len();
    if count < many.0.paths.len() {
        // By the numbers if they show it, else the first surplus one.
        let (known, all) = (place_of(few.1), place_of(many.1));
        let by_number = few.1.iter().all(|key| all.contains_key(key));
        let first = if by_number { many.1.iter().position(|key| !known.contains_key(key)) } else { None };
        bail!(
            "LEFT {:?} has {} frames and RIGHT {:?} {}; the first without a partner is {:?}: remove it, or add the other",
            left.given,
            left.paths.len(),
            right.given,
            right.paths.len(),
            many.0.paths[first.unwrap_or(count)]
        );
    }
    // Time stamps of two cameras never agree, counters always do: if some numbers agree, all must, and no number may occur at
    // another place on the other side.
    let on_the_right = place_of(&right_keys);
    let pairs = || left_keys.iter().zip(&right_keys);
    let some_agree = pairs().any(|(left, right)| left == right);
    let wrong = pairs().position(|(left, right)| left != right && (some_agree || on_the_right.contains_key(left)));
    if let Some(i) = wrong {
        bail!(
            "{:?} would be paired with {:?}, which has another number; remove the frames that have no partner",
            left.paths[i],
            right.paths[i]
        );
    }
    Ok(())
}

/// The key of each frame of a side: the numbers in its path that vary, or else its name.
fn keys(paths: &[PathBuf]) -> Vec<Vec<String>> {
    let numbers = |path: &PathBuf| -> Vec<String> {
        let text = path.with_extension("").to_string_lossy().into_owned();
        let runs = text.split(|c: char| !c.is_ascii_digit()).filter(|run| !run.is_empty());
        runs.map(|run| run.trim_start_matches('0').to_owned()).collect()
    };
    let numbers: Vec<_> = paths.iter().map(numbers).collect();
    let columns = numbers.iter().map(Vec::len).min().unwrap_or_default();
    let changes = |&column: &usize| numbers.iter().any(|of| of[column] != numbers[0][column]);
    let changing: Vec<_> = (0..columns).filter(changes).collect();
    let name = |path: &PathBuf| vec![path.file_stem().unwrap_or_default().to_string_lossy().into_owned()];
    match changing[..] {
        [] => paths.iter().map(name).collect(),
        _ => numbers.iter().map(|of| changing.iter().map(|&column| of[column].clone()).collect()).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Option<Pattern> {
        Pattern::parse(Path::new(text)).unwrap()
    }

    #[test]
    fn patterns_are_as_printf() {
        let path = |text: &str, number| parsed(text).unwrap().path(number);
        assert_eq!(path("a/img_%06d.png", 7), Path::new("a/img_000007.png"));
        assert_eq!(path("%d.png", 12), Path::new("12.png"));
        assert_eq!(path("50%%_%03d_10.png", 1234), Path::new("50%_1234_10.png"));
        assert_eq!(parsed("a/*.png"), None);
        for text in
            ["%s.png", "%d_%d.png", "%6d.png", "%.png", "%06.png", "a%d/b.png", "a%d/%d.png", "%%.png", "%099d.png"]
        {
            assert!(Pattern::parse(Path::new(text)).is_err(), "{text}");
        }
    }

    #[test]
    fn a_number_is_read_as_it_is_written() {
        let number = |text: &str, name: &str| parsed(text).unwrap().number(name);
        assert_eq!(number("img_%03d.png", "img_007.png"), Some(7));
        assert_eq!(number("img_%03d.png", "img_1007.png"), Some(1007));
        for name in ["img_7.png", "img_0007.png", "img_+07.png", "img_.png", "img_007.jpg", "007.png", "img_00a.png"] {
            assert_eq!(number("img_%03d.png", name), None, "{name}");
        }
        assert_eq!(number("aa%da.png", "aa.png"), None);
    }

    #[test]
    fn what_is_there_by_its_name_is_no_pattern() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["l [0]", "l 0", "100%_a", "{x}*", "l [0]/in [1]"] {
            fs::create_dir(at(name)).unwrap();
        }
        for name in ["l [0]/1.png", "l [0]/10.png", "l 0/other.png", "100%_a/f_1.png", "a[1].png", "a1.png", "50%d.png"]
        {
            fs::write(at(name), "").unwrap();
        }
        fs::write(at("{x}*/1.png"), "").unwrap();
        fs::write(at("l [0]/in [1]/2.png"), "").unwrap();
        let found = |given: &str| {
            let side = Side::find("LEFT", &at(given)).map_err(|error| format!("{error:#}"))?;
            let below =
                side.paths.iter().map(|path| path.strip_prefix(folder.path()).unwrap().to_str().unwrap().into());
            Ok::<Vec<String>, String>(below.collect())
        };
        for (given, expected) in [
            ("l [0]/*.png", &["l [0]/1.png", "l [0]/10.png"][..]),
            ("l [0]/%d.png", &["l [0]/1.png"]),
            ("l [0]", &["l [0]/1.png", "l [0]/10.png"]),
            ("l [0]/in [1]/?.png", &["l [0]/in [1]/2.png"]),
            ("l [0]/*/2.png", &["l [0]/in [1]/2.png"]),
            ("l [[]0]/1*.png", &["l [0]/1.png", "l [0]/10.png"]),
            ("100%_a/f_%d.png", &["100%_a/f_1.png"]),
            ("100%_a/*.png", &["100%_a/f_1.png"]),
            ("100%%_a/*.png", &[]),
            ("100%%_a/f_%d.png", &["100%_a/f_1.png"]),
            ("{x}*/*.png", &["{x}*/1.png"]),
            ("a[1].png", &["a[1].png"]),
            ("a[0-9].png", &["a1.png"]),
            ("50%d.png", &["50%d.png"]),
        ] {
            match found(given) {
                Ok(found) => assert_eq!(found, expected, "{given}"),
                Err(error) => assert!(expected.is_empty(), "{given}: {error}"),
            }
        }
        let error = found("l [0]/*.jpg").unwrap_err();
        assert!(
            error.contains("has \"1.png\", for example, but nothing like \"*.jpg\"") && error.contains("[[]"),
            "{error}"
        );
        assert!(found("l [1]/*.png").is_err() && found("l [/*.png").unwrap_err().contains("[[] for ["));
        assert!(found("none/*.png").unwrap_err().contains("none\"; give a folder"));
    }

    #[test]
    fn frames_are_in_step_by_the_numbers_that_change() {
        let side = |names: &[&str]| Side {
            given: "x".into(),
            paths: names.iter().map(PathBuf::from).collect(),
            first: 0,
            gap: None,
        };
        let told = |left: &[&str], right: &[&str]| {
            ensure_in_step(&side(left), &side(right)).err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert_eq!(told(&["l/0_10.png", "l/1_10.png"], &["r/0_10.png", "r/1_10.png"]), "");
        assert_eq!(told(&["c0_1.png", "c0_2.png"], &["c1_001.png", "c1_002.png"]), "");
        assert_eq!(told(&["1_cam0.png", "2_cam0.png"], &["1_cam1.png", "2_cam1.png"]), "");
        assert_eq!(told(&["a.png", "b.png"], &["c.png", "d.png"]), "");
        assert_eq!(told(&["t17.png", "t29.png"], &["t18.png", "t30.png"]), ""); // stamps of two clocks
        for left in [["l0.png", "l1.png", "l3.png"], ["l1.png", "l2.png", "l3.png"]] {
            let text = told(&left, &["r0.png", "r2.png", "r3.png"]);
            assert!(text.contains("\"l1.png\" would be paired with \"r"), "{text}");
        }
        let text = told(&["l0.png", "l1.png", "l2.png"], &["r0.png", "r2.png"]);
        assert!(text.contains("3 frames") && text.contains("2;") && text.contains("\"l1.png\""), "{text}");
        let text = told(&["a.png"], &["b.png", "c.png"]);
        assert!(text.contains("\"c.png\""), "{text}");
    }
}
