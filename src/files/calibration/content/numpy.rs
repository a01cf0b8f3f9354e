//! NumPy's arrays in YAML as PyYAML dumps them when they are not turned into lists: their bytes, in base 64.

use super::node::Node;
use crate::files::maps::npy::transposed;

/// The most numbers of an array that is read.
const MAX_NUMBERS: usize = 1024;

/// The array that a call of `numpy.core.multiarray._reconstruct` makes, by its `state`: a version, the shape, the type, whether
/// the first side runs fastest, and the bytes. A map of rows, cols and data.
pub fn array(call: &Node) -> Option<Node> {
    let Node::List(state) = call.get("state")? else { return None };
    let [_, Node::List(shape), kind, Node::Scalar(by_columns), Node::Scalar(bytes)] = &state[..] else { return None };
    let shape: Vec<usize> = shape
        .iter()
        .map(|side| match side {
            Node::Scalar(text) => text.parse().ok(),
            _ => None,
        })
        .collect::<Option<_>>()?;
    let [rows, cols] = match shape[..] {
        [] => [1, 1],
        [count] => [1, count],
        [rows, cols] => [rows, cols],
        _ => return None,
    };
    let count = rows.checked_mul(cols).filter(|count| *count <= MAX_NUMBERS)?;
    let bytes = base64(bytes)?;
    let numbers = numbers(&scalars(kind), &bytes).filter(|numbers| numbers.len() == count)?;
    let numbers = if by_columns == "true" { transposed(&numbers, [cols, rows]) } else { numbers };
    let scalar = |text: String| Node::Scalar(text);
    let data = Node::List(numbers.iter().map(|number| scalar(format!("{number:?}"))).collect());
    let mut items = vec![("data".to_string(), data)];
    if shape.len() == 2 {
        items.push(("rows".into(), scalar(rows.to_string())));
        items.push(("cols".into(), scalar(cols.to_string())));
    }
    Some(Node::Map(items))
}

/// All scalars of a value.
fn scalars(node: &Node) -> Vec<&str> {
    match node {
        Node::Scalar(text) => vec![text],
        Node::List(items) => items.iter().flat_map(scalars).collect(),
        Node::Map(items) => items.iter().flat_map(|(_, item)| scalars(item)).collect(),
    }
}

/// The numbers of these bytes, by the words that describe their type.
fn numbers(kind: &[&str], bytes: &[u8]) -> Option<Vec<f64>> {
    let reversed = kind.contains(&">");
    let word = kind.iter().find(|word| ["f8", "f4", "i8", "i4"].contains(word))?;
    let size = if word.ends_with('8') { 8 } else { 4 };
    let number = |bytes: &[u8]| {
        let mut padded = [0; 8];
        let order = |i: usize| if reversed { size - 1 - i } else { i };
        (0..size).for_each(|i| padded[order(i)] = bytes[i]);
        let low = [padded[0], padded[1], padded[2], padded[3]];
        match *word {
            "f8" => f64::from_le_bytes(padded),
            "f4" => f32::from_le_bytes(low).into(),
            "i8" => i64::from_le_bytes(padded) as f64,
            _ => i32::from_le_bytes(low).into(),
        }
    };
    let chunks = bytes.chunks_exact(size);
    chunks.remainder().is_empty().then(|| chunks.map(number).collect())
}

fn base64(text: &str) -> Option<Vec<u8>> {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digits = text.bytes().filter(|byte| !byte.is_ascii_whitespace() && *byte != b'=');
    let values = digits.map(|byte| DIGITS.iter().position(|digit| *digit == byte));
    let values: Vec<usize> = values.collect::<Option<_>>()?;
    let bytes = values.chunks(4).flat_map(|four| {
        let all = (0..4).fold(0, |all, i| all << 6 | four.get(i).copied().unwrap_or(0));
        [all >> 16, all >> 8, all].map(|byte| byte as u8).into_iter().take((four.len() * 6) / 8)
    });
    Some(bytes.collect())
}
