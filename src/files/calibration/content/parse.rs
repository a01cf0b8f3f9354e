//! YAML and JSON as the values under each path of names.

use super::node::{MAX_DEPTH, Node};
use super::tree::Tree;
use super::yaml as events;
use crate::files::error::{Result, ensure, error};
use serde_json::Value;

/// Of YAML; `known`: what is read, for errors. OpenCV's header, `%YAML:1.0`, is not YAML's.
pub fn yaml(text: &str, known: &str) -> Result<Tree> {
    let body = match text.trim_start().strip_prefix('%') {
        Some(rest) => rest.split_once('\n').map_or("", |(_, body)| body),
        None => text,
    };
    events::node(body, known)?.tree(known)
}

/// Of JSON. What is no JSON may still be YAML, which has such brackets, too.
pub fn json(text: &str, known: &str) -> Result<Tree> {
    match serde_json::from_str::<Value>(text) {
        Ok(value) => node(&value, 0)?.tree(known),
        Err(error) => {
            yaml(text, known).map_err(|_| error!("it is damaged JSON ({error}); save it again, or give one of {known}"))
        }
    }
}

fn node(value: &Value, depth: usize) -> Result<Node> {
    ensure!(depth <= MAX_DEPTH, "it is nested more than {MAX_DEPTH} deep; that is no calibration");
    Ok(match value {
        Value::String(text) => Node::Scalar(text.clone()),
        Value::Array(items) => Node::List(items.iter().map(|item| node(item, depth + 1)).collect::<Result<_>>()?),
        Value::Object(items) => {
            let named = items.iter().map(|(name, item)| Ok((name.clone(), node(item, depth + 1)?)));
            Node::Map(named.collect::<Result<_>>()?)
        }
        other => Node::Scalar(other.to_string()),
    })
}

#[cfg(test)]
mod tests {
    use rand::{Rng as _, SeedableRng as _};
    use serde_json::Value;

    #[test]
    fn numbers_of_json_are_read_to_the_bit() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        for _ in 0..20_000 {
            let number = f64::from_bits(random.random());
            if number.is_finite() {
                let text = format!("{number:e}");
                let read = serde_json::from_str::<Value>(&text).unwrap().as_f64().unwrap();
                assert_eq!(read.to_bits(), number.to_bits(), "{text}");
            }
        }
    }
}
