//! YAML's events as a value.

use super::node::{MAX_DEPTH, MAX_NODES, Node};
use super::numpy;
use crate::files::error::{Context as _, Result, bail, ensure, error};
use std::collections::BTreeMap;
use yaml_rust2::Event;
use yaml_rust2::parser::Parser;

/// Reads the first document that holds something; `known`: what is read, for errors.
pub fn node(text: &str, known: &str) -> Result<Node> {
    let mut reader = Reader { parser: Parser::new_from_str(text), known, anchors: BTreeMap::new(), nodes: 0 };
    loop {
        match reader.next()? {
            Event::StreamEnd => return Ok(Node::List(Vec::new())),
            Event::StreamStart | Event::DocumentStart | Event::DocumentEnd | Event::Nothing => {}
            event => match reader.value(event, 0)? {
                Node::Scalar(_) => {}
                node => return Ok(node),
            },
        }
    }
}

struct Reader<'a> {
    parser: Parser<std::str::Chars<'a>>,
    known: &'a str,
    /// What was named by `&name`, by its number.
    anchors: BTreeMap<usize, Node>,
    nodes: usize,
}

impl Reader<'_> {
    fn next(&mut self) -> Result<Event> {
        let known = self.known;
        let event = self.parser.next_token().map_err(|error| {
            error!("it is neither a calibration of a known kind nor YAML ({error}); give one of {known}")
        })?;
        Ok(event.0)
    }

    /// The value that begins with an event.
    fn value(&mut self, event: Event, depth: usize) -> Result<Node> {
        ensure!(depth <= MAX_DEPTH, "it is nested more than {MAX_DEPTH} deep; that is no calibration");
        let (node, anchor) = match event {
            Event::Alias(anchor) => {
                let node = self.anchors.get(&anchor).context("it has an alias (*name) of what is not there")?;
                (node.clone(), 0)
            }
            Event::Scalar(text, _, anchor, _) => (Node::Scalar(text), anchor),
            Event::SequenceStart(anchor, _) => {
                let mut items = Vec::new();
                loop {
                    match self.next()? {
                        Event::SequenceEnd => break,
                        event => items.push(self.value(event, depth + 1)?),
                    }
                }
                (Node::List(items), anchor)
            }
            Event::MappingStart(anchor, _) => {
                let mut items = Vec::new();
                loop {
                    let name = match self.next()? {
                        Event::MappingEnd => break,
                        Event::Scalar(name, ..) => name,
                        _ => bail!("it has a key that is no name; that is no calibration"),
                    };
                    let event = self.next()?;
                    items.push((name, self.value(event, depth + 1)?));
                }
                let map = Node::Map(items);
                (numpy::array(&map).unwrap_or(map), anchor)
            }
            _ => bail!("it ends in the middle of a value; save it again"),
        };
        self.nodes += if anchor == 0 { node.count() } else { 1 };
        ensure!(self.nodes <= MAX_NODES, "it has more than {MAX_NODES} values; that is no calibration");
        if anchor != 0 {
            self.anchors.insert(anchor, node.clone());
        }
        Ok(node)
    }
}
