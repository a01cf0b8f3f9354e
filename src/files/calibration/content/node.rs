//! A value of YAML or JSON, and the scalars under each path of its names.

use super::tree::Tree;
use crate::files::error::{Result, ensure};

/// The deepest nesting that is read.
pub const MAX_DEPTH: usize = 16;
/// The most values, aliases counted each time.
pub const MAX_NODES: usize = 100_000;

/// A value.
#[derive(Clone, Debug)]
pub enum Node {
    /// A number, a text or the like, as it is written.
    Scalar(String),
    /// Several, in order.
    List(Vec<Self>),
    /// Named ones, in order.
    Map(Vec<(String, Self)>),
}

impl Node {
    /// How many values it has, itself included.
    pub fn count(&self) -> usize {
        1 + match self {
            Self::Scalar(_) => 0,
            Self::List(items) => items.iter().map(Self::count).sum(),
            Self::Map(items) => items.iter().map(|(_, item)| item.count()).sum(),
        }
    }

    /// The value of this name.
    pub fn get(&self, name: &str) -> Option<&Self> {
        let Self::Map(items) = self else { return None };
        items.iter().find(|(key, _)| key == name).map(|(_, item)| item)
    }

    fn has_names(&self) -> bool {
        match self {
            Self::Scalar(_) => false,
            Self::List(items) => items.iter().any(Self::has_names),
            Self::Map(_) => true,
        }
    }

    /// The scalars under each path. Lists of lists are one list; of lists that hold named values the number is a name.
    pub fn tree(&self, known: &str) -> Result<Tree> {
        let mut tree = Tree::new();
        self.fill(&mut Vec::new(), &mut tree);
        ensure!(!tree.is_empty(), "it holds no named value; give a calibration of {known}");
        Ok(tree)
    }

    fn fill(&self, path: &mut Vec<String>, tree: &mut Tree) {
        match self {
            Self::Scalar(text) if !path.is_empty() => tree.entry(path.join(".")).or_default().push(text.clone()),
            Self::Scalar(_) => {}
            Self::List(items) if self.has_names() => {
                for (i, item) in items.iter().enumerate() {
                    path.push(i.to_string());
                    item.fill(path, tree);
                    path.pop();
                }
            }
            Self::List(items) => {
                if !path.is_empty() {
                    tree.entry(path.join(".")).or_default();
                }
                items.iter().for_each(|item| item.fill(path, tree));
            }
            Self::Map(items) => {
                for (name, item) in items {
                    path.push(name.clone());
                    item.fill(path, tree);
                    path.pop();
                }
            }
        }
    }
}
