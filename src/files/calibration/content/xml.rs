//! OpenCV's XML.

use super::node::MAX_DEPTH;
use super::tree::Tree;
use crate::files::error::{Result, ensure, error};

/// The values of an XML file of OpenCV: `<opencv_storage><P1 type_id="opencv-matrix"><rows>3</rows>..`.
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
