//! Lists of pairs, as CSV or as JSON lines.

use super::contents::pointer;
use super::error::{Context as _, Error, Result, bail, ensure, error};
use super::json_path::JsonPath;
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::HashSet;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// The largest list that is read.
const MAX_BYTES: u64 = 1 << 28;

/// A pair, and the name of its map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listed {
    /// The line of the list, if it is in one.
    pub line: Option<usize>,
    /// The left image.
    pub left: PathBuf,
    /// The right image; the left one again if one file holds both views.
    pub right: PathBuf,
    /// A path within the output folder, without an ending; `None`: that of the left image.
    pub name: Option<PathBuf>,
}

/// How a list is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Left, right and perhaps a name, with or without a header; or left alone.
    Csv,
    /// An object a line.
    JsonLines,
}

/// Whether a path is that of a list, by its ending, or `-`.
#[must_use]
pub fn is_list(path: &Path) -> bool {
    path == Path::new("-") || kind_of(path).is_some()
}

fn kind_of(path: &Path) -> Option<Kind> {
    match path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase().as_str() {
        "csv" => Some(Kind::Csv),
        "jsonl" | "ndjson" => Some(Kind::JsonLines),
        _ => None,
    }
}

/// The pairs of a list, at least one. Their paths are relative to the list's folder, or, from stdin (`-`), to this one.
///
/// # Errors
/// If the list cannot be read, has no pair, or has a line that is not one.
pub fn read(path: &Path) -> Result<Vec<Listed>> {
    let kind = kind_of(path);
    if !is_list(path) {
        bail!(
            "LIST is {path:?}, but a list ends in .csv, .jsonl or .ndjson, or is - for stdin; rename it, give LEFT and \
             RIGHT, or say by --split how each image holds both views"
        );
    }
    let text = match kind {
        None => text(std::io::stdin().lock()),
        Some(_) => File::open(path).map_err(Into::into).and_then(text),
    };
    let text = text.with_context(|| format!("list {path:?} cannot be read"))?;
    if let Some(pointer) = pointer(text.as_bytes()) {
        bail!("list {path:?} is {pointer}");
    }
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let guess = if text.trim_start().starts_with('{') { Kind::JsonLines } else { Kind::Csv };
    let mut all = parse(text, kind.unwrap_or(guess)).with_context(|| format!("list {path:?}"))?;
    ensure!(!all.is_empty(), "list {path:?} has no pairs; give lines such as left.png,right.png");
    let folder = path.parent().unwrap_or(Path::new(""));
    for pair in &mut all {
        (pair.left, pair.right) = (folder.join(&pair.left), folder.join(&pair.right));
    }
    Ok(all)
}

fn text(source: impl Read) -> Result<String> {
    let mut text = String::new();
    source.take(MAX_BYTES + 1).read_to_string(&mut text)?;
    ensure!(text.len() as u64 <= MAX_BYTES, "it has more than {MAX_BYTES} bytes; split it");
    Ok(text)
}

/// The pairs of a list's text.
///
/// # Errors
/// If a line is not a pair.
pub fn parse(text: &str, kind: Kind) -> Result<Vec<Listed>> {
    let mut columns = None;
    let mut all = Vec::new();
    for (line, text) in (1..).zip(text.lines()) {
        if text.trim().is_empty() || (kind == Kind::Csv && text.starts_with('#')) {
            continue;
        }
        let row = match kind {
            Kind::Csv => csv_row(text, &mut columns),
            Kind::JsonLines => json_row(text).map(Some),
        };
        let listed = row.and_then(|row| row.map(|row| row.listed(line)).transpose());
        let listed = listed.with_context(|| format!("line {line}"))?;
        if let (Some(first), Some(listed)) = (all.first(), &listed) {
            ensure!(
                is_alone(first) == is_alone(listed),
                "line {line}: right is missing here or in the lines before, but not in both; add it, or give files that hold \
                 both views in a list of their own"
            );
        }
        all.extend(listed);
    }
    Ok(all)
}

/// Whether one file holds both views.
fn is_alone(pair: &Listed) -> bool {
    pair.left == pair.right
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    left: JsonPath,
    /// None where the left one holds both views.
    right: Option<JsonPath>,
    name: Option<JsonPath>,
    /// The log of failures is a list, too.
    #[serde(rename = "error")]
    _error: Option<IgnoredAny>,
}

impl Row {
    fn listed(self, line: usize) -> Result<Listed> {
        let (left, right) = (self.left.0, self.right.map(|right| right.0));
        for (side, path) in [("left", Some(&left)), ("right", right.as_ref())] {
            ensure!(path.is_none_or(|path| path != Path::new("")), "{side} is empty; give the path of an image");
        }
        let name = self.name.filter(|name| name.0 != Path::new("")).map(|name| within(&name.0)).transpose()?;
        Ok(Listed { line: Some(line), right: right.unwrap_or_else(|| left.clone()), left, name })
    }
}

/// A path that does not lead out of the folder that it is joined to.
fn within(name: &Path) -> Result<PathBuf> {
    let mut parts = name.components().filter(|part| *part != Component::CurDir).peekable();
    let leads_out = parts.clone().any(|part| !matches!(part, Component::Normal(_)));
    ensure!(
        parts.peek().is_some() && !leads_out && !name.to_string_lossy().contains(char::is_control),
        "name is {name:?}, but must be a path within the output folder, such as scene/0001; remove .. and the root"
    );
    Ok(parts.collect())
}

fn json_row(text: &str) -> Result<Row> {
    serde_json::from_str(text).map_err(|error| {
        let told = error.to_string();
        let told = told.split(" at line ").next().unwrap_or_default();
        error!(
            "{told} (column {}); give an object such as {{\"left\": \"l.png\", \"right\": \"r.png\", \"name\": \"a\"}}",
            error.column()
        )
    })
}

/// Where left, right and name stand.
type Columns = [Option<usize>; 3];

/// Without a header.
const BARE: Columns = [Some(0), Some(1), Some(2)];
/// Without a header, if the first line has one field.
const ALONE: Columns = [Some(0), None, None];

const NAMES: [&str; 3] = ["left", "right", "name"];

/// A row, or nothing if the line is the header, which can only be the first one.
fn csv_row(text: &str, columns: &mut Option<Columns>) -> Result<Option<Row>> {
    ensure!(
        text.matches('"').count().is_multiple_of(2),
        "a quote is not closed; quote as in \"a, b.png\",\"say \"\"c\"\".png\""
    );
    let mut reader = csv::ReaderBuilder::new().has_headers(false).trim(csv::Trim::All).from_reader(text.as_bytes());
    let record = reader.records().next().context("it has no field")?.map_err(|error| Error::of(&error))?;
    let Some(columns) = columns else {
        let header: Vec<_> = record.iter().map(str::to_ascii_lowercase).collect();
        let is_header = header.iter().any(|field| field == "left");
        if !is_header {
            let is_alone = record.len() == 1 && !text.contains([';', '\t']);
            *columns = Some(if is_alone { ALONE } else { BARE });
            return csv_row(text, columns);
        }
        let mut known = HashSet::new();
        if let Some(field) = header.iter().find(|field| !NAMES.contains(&field.as_str()) || !known.insert(*field)) {
            bail!("the header has {field:?}, but left, right and name are known, each once; remove the column");
        }
        *columns = Some(NAMES.map(|name| header.iter().position(|field| field == name)));
        return Ok(None);
    };
    let (count, header) = (record.len(), columns.iter().flatten().count());
    ensure!(
        if *columns == BARE { count == 2 || count == 3 } else { count == header },
        "it has {count} fields, but {} are expected; separate them by commas",
        if *columns == BARE {
            "left,right or left,right,name".into()
        } else {
            format!("{header}, as in the first line,")
        }
    );
    let [left, right, name] = columns.map(|column| column.and_then(|column| record.get(column)).map(JsonPath::from));
    Ok(Some(Row { left: left.unwrap_or_else(|| JsonPath::from("")), right, name, _error: None }))
}

/// The name of each pair. One without a name has that of its left image below the folder that all such images are in.
pub fn names(all: &[Listed]) -> Result<Vec<PathBuf>> {
    let unnamed = all.iter().filter(|pair| pair.name.is_none()).map(|pair| absolute(&pair.left));
    let common = unnamed.map(|left| left.parent().map(Path::to_owned).unwrap_or_default()).reduce(|a, b| {
        let same = a.components().zip(b.components()).take_while(|(a, b)| a == b);
        same.map(|(part, _)| part).collect()
    });
    let common = common.unwrap_or_default();
    let name = |pair: &Listed| match &pair.name {
        Some(name) => Ok(name.clone()),
        None => {
            let left = absolute(&pair.left);
            let below = left.strip_prefix(&common).unwrap_or(&left).with_extension("");
            let leads_out = below.components().any(|part| !matches!(part, Component::Normal(_)));
            ensure!(
                !leads_out && below != Path::new(""),
                "{:?} yields no name for its map within the output folder; name it in the list",
                pair.left
            );
            Ok(below)
        }
    };
    all.iter().map(name).collect()
}

/// An absolute path; symbolic links are not followed.
pub fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng as _, SeedableRng as _};

    fn listed(line: usize, left: &str, right: &str, name: Option<&str>) -> Listed {
        Listed { line: Some(line), left: left.into(), right: right.into(), name: name.map(Into::into) }
    }

    #[test]
    fn rows_are_read_with_and_without_a_header() {
        let expected = [listed(2, "a, b.png", "r \"1\".png", Some("x/y")), listed(5, "c.png", "d.png", None)];
        let text = "# pairs\n\"a, b.png\" ,\"r \"\"1\"\".png\",./x//y\n\n  \nc.png, d.png\n";
        assert_eq!(parse(text, Kind::Csv).unwrap(), expected);
        let text = "Name,Right,Left\r\n,b.png,a.png\r\n";
        assert_eq!(parse(text, Kind::Csv).unwrap(), [listed(2, "a.png", "b.png", None)]);
        let text = "{\"left\": \"a\\nb\", \"right\": \"#r\"}\n\n{\"right\":\"r\",\"left\":\"l\",\"name\":\"n\",\"error\":\"e\"}";
        let expected = [listed(1, "a\nb", "#r", None), listed(3, "l", "r", Some("n"))];
        assert_eq!(parse(text, Kind::JsonLines).unwrap(), expected);
    }

    #[test]
    fn whatever_a_list_holds_is_read_or_refused() {
        let lists = [
            (Kind::Csv, "left,right,name\n\"a, b.png\",c.png,x/y\n# no\nd.png,e.png,\n"),
            (Kind::JsonLines, "{\"left\": \"a.png\", \"right\": \"\\u00e4.png\", \"name\": \"x/y\"}\n"),
        ];
        let pieces = ["\"", ",", "\n", "\\", "..", "/", "{", "}", "\0", "ä", "left", "\r", ":", "null", "#"];
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let (mut read, mut refused) = (0, 0);
        for _ in 0..20_000 {
            let (kind, text) = lists[rng.random_range(0..2)];
            let mut chars: Vec<char> = text.chars().collect();
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..chars.len());
                let piece = pieces[rng.random_range(0..pieces.len())];
                chars.splice(at..(at + rng.random_range(0..3)).min(chars.len()), piece.chars());
            }
            match parse(&chars.into_iter().collect::<String>(), kind) {
                Ok(all) => {
                    read += 1;
                    for pair in all {
                        assert!(pair.left != Path::new("") && pair.right != Path::new(""));
                        let name = Path::new("out").join(pair.name.unwrap_or_default());
                        assert!(name.starts_with("out") && !name.components().any(|part| part == Component::ParentDir));
                    }
                }
                Err(error) => {
                    refused += 1;
                    assert!(format!("{error:#}").starts_with("line "), "{error:#}");
                }
            }
        }
        assert!(read > 1000 && refused > 1000, "{read} {refused}");
    }

    #[test]
    fn names_are_those_of_the_left_images_below_their_common_folder() {
        let name = |lefts: &[&str]| {
            let all: Vec<_> = lefts.iter().map(|left| listed(1, left, "r", None)).collect();
            names(&all).map(|names| names.iter().map(|name| name.to_string_lossy().into_owned()).collect::<Vec<_>>())
        };
        assert_eq!(name(&["d/s1/im0.png", "d/s2/im0.png"]).unwrap(), ["s1/im0", "s2/im0"]);
        assert_eq!(name(&["../d/a.1.png"]).unwrap(), ["a.1"]);
        assert_eq!(name(&["/a/x.png", "/ab/x.png"]).unwrap(), ["a/x", "ab/x"]);
        assert!(name(&["a.png", "../b.png"]).is_err());
        // Those with a name of their own do not count.
        let all = [listed(1, "d/s1/im0.png", "r", None), listed(2, "/e/im0.png", "r", Some("e"))];
        assert_eq!(names(&all).unwrap(), [Path::new("im0"), Path::new("e")]);
    }
}
