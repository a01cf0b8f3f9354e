//! The scalars under each path of names, and matrices among them.

use crate::files::error::{Context as _, Result, bail, ensure, error};
use std::collections::BTreeMap;

/// The scalars under each path of names, which are joined by dots.
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
