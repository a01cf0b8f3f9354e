//! YAML and XML: the scalars under each path of names.

use crate::files::error::{Context as _, Result, bail, ensure, error};
use std::collections::BTreeMap;
use yaml_rust2::Event;
use yaml_rust2::parser::Parser;

/// The deepest nesting that is read.
const MAX_DEPTH: usize = 16;

pub type Tree = BTreeMap<String, Vec<String>>;

pub fn number(text: &str) -> Result<f64> {
    let value: f64 = text.trim().parse().map_err(|_| error!("{text:?} is not a number; correct the file"))?;
    ensure!(value.is_finite(), "{text:?} is not finite; correct the file");
    Ok(value)
}

pub fn whole(text: &str) -> Result<u32> {
    match number(text)? {
        value if value.fract() == 0.0 && (1.0..=1e6).contains(&value) => Ok(value as u32),
        _ => bail!("{text:?} is not a size; give a whole number from 1 on"),
    }
}

/// Whether one of the names is there, as a list or as a matrix.
pub fn has(tree: &Tree, names: &[&str]) -> bool {
    let part = |name: &str, part: &str| tree.contains_key(&format!("{name}.{part}"));
    names.iter().any(|name| tree.contains_key(*name) || part(name, "rows") || part(name, "data"))
}

/// Columns and rows of the images, if they are there.
pub fn size_of(tree: &Tree) -> Result<Option<[u32; 2]>> {
    let one = |names: &[&str]| names.iter().find_map(|name| tree.get(*name)).and_then(|values| values.first());
    for name in ["image_size", "imageSize", "size"] {
        if let Some([width, height]) = tree.get(name).map(Vec::as_slice) {
            return Ok(Some([whole(width)?, whole(height)?]));
        }
    }
    let width = one(&["image_width", "width", "imageWidth", "LEFT.width"]);
    match (width, one(&["image_height", "height", "imageHeight", "LEFT.height"])) {
        (Some(width), Some(height)) => Ok(Some([whole(width)?, whole(height)?])),
        _ => Ok(None),
    }
}

/// The numbers of a matrix by rows, if one of the names is there; it has one of the shapes.
pub fn matrix(tree: &Tree, names: &[&str], shapes: &[(usize, usize)]) -> Result<Option<Vec<f64>>> {
    for name in names {
        let at = |part: &str| tree.get(&format!("{name}.{part}"));
        let (rows, columns) = (at("rows").and_then(|v| v.first()), at("cols").and_then(|v| v.first()));
        let Some(data) = at("data").or_else(|| tree.get(*name)).or(rows.map(|_| const { &Vec::new() })) else {
            continue;
        };
        let numbers =
            data.iter().map(|text| number(text)).collect::<Result<Vec<_>>>().with_context(|| format!("its {name}"))?;
        let allowed = || {
            let some = shapes.iter().filter(|(rows, columns)| rows * columns > 0);
            some.map(|(rows, columns)| format!("{rows} x {columns}")).collect::<Vec<_>>().join(" or ")
        };
        let fits = |&(r, c): &(usize, usize)| {
            let is = |side: Option<&String>, of: usize| side.is_none_or(|text| text.trim().parse() == Ok(of));
            numbers.len() == r * c && (numbers.is_empty() || is(rows, r) && is(columns, c))
        };
        if !shapes.iter().any(fits) {
            let told = match (rows, columns) {
                (Some(rows), Some(columns)) => format!("{rows} x {columns} with {} numbers", numbers.len()),
                _ => format!("{} numbers", numbers.len()),
            };
            bail!("its {name} is {told}, but must be {}; correct the file", allowed());
        }
        return Ok(Some(numbers));
    }
    Ok(None)
}

/// Of YAML; `known`: what is read, for errors. OpenCV's header, `%YAML:1.0`, is not YAML's.
pub fn yaml(text: &str, known: &str) -> Result<Tree> {
    let body: String = match text.trim_start().strip_prefix('%') {
        Some(rest) => rest.split_once('\n').map_or(String::new(), |(_, body)| body.into()),
        None => text.into(),
    };
    let mut tree = Tree::new();
    let mut parser = Parser::new_from_str(&body);
    // For each open mapping the key whose value comes next, for each open sequence `None`.
    let mut open: Vec<Option<Option<String>>> = Vec::new();
    loop {
        let (event, _) = parser.next_token().map_err(|error| {
            error!("it is neither a calibration of a known kind nor YAML ({error}); give one of {}", known)
        })?;
        match event {
            Event::StreamEnd => break,
            Event::Scalar(text, ..) => match open.last_mut() {
                Some(Some(key @ None)) => *key = Some(text),
                Some(_) => {
                    tree.entry(path_of(&open)).or_default().push(text);
                    filled(&mut open);
                }
                None => {}
            },
            Event::Alias(_) => bail!("it has an alias (*name); write its value in its place"),
            Event::MappingStart(..) | Event::SequenceStart(..) => {
                ensure!(open.len() < MAX_DEPTH, "it is nested more than {MAX_DEPTH} deep; that is no calibration");
                ensure!(
                    !matches!(open.last(), Some(Some(None))),
                    "it has a key that is no name; that is no calibration"
                );
                // A list may be empty.
                if matches!((&event, open.last()), (Event::SequenceStart(..), Some(Some(Some(_))))) {
                    tree.entry(path_of(&open)).or_default();
                }
                open.push(matches!(event, Event::MappingStart(..)).then_some(None));
            }
            Event::MappingEnd | Event::SequenceEnd => {
                open.pop();
                filled(&mut open);
            }
            _ => {}
        }
    }
    ensure!(!tree.is_empty(), "it holds no named value; give a calibration of {}", known);
    Ok(tree)
}

fn path_of(open: &[Option<Option<String>>]) -> String {
    open.iter().flatten().flatten().map(String::as_str).collect::<Vec<_>>().join(".")
}

/// Marks the value of the current key of the innermost mapping as read.
fn filled(open: &mut [Option<Option<String>>]) {
    if let Some(Some(key)) = open.last_mut() {
        *key = None;
    }
}

/// The same of an XML file of OpenCV: `<opencv_storage><P1 type_id="opencv-matrix"><rows>3</rows>..`.
pub fn xml(text: &str, known: &str) -> Result<Tree> {
    // Many nested namespaces cost minutes: every element inherits those of all that enclose it.
    ensure!(!text.contains("xmlns"), "it has a namespace (xmlns), which OpenCV does not write; save it again");
    let options = roxmltree::ParsingOptions { nodes_limit: 100_000, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(text, options)
        .map_err(|error| error!("it is damaged XML ({error}); save it again"))?;
    let mut tree = Tree::new();
    for node in document.root_element().descendants().filter(roxmltree::Node::is_text) {
        let names: Vec<_> = node.ancestors().filter(roxmltree::Node::is_element).take(MAX_DEPTH).collect();
        // The names from the root's children on; `_` is an item of a sequence.
        let path: Vec<_> =
            names.iter().rev().skip(1).map(|n| n.tag_name().name()).filter(|name| *name != "_").collect();
        let words = node.text().unwrap_or_default().split_whitespace().map(str::to_string);
        tree.entry(path.join(".")).or_default().extend(words);
    }
    tree.retain(|_, words| !words.is_empty());
    ensure!(!tree.is_empty(), "it holds no named value; give a calibration of {}", known);
    Ok(tree)
}
