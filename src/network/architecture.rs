//! The two architectures, and whether tensors are one's.

use std::collections::BTreeMap;
use std::fmt;

use super::graph::{Kind, Operation, basic, stack_hourglass};
use super::tensor::Tensors;
use crate::Error;

/// The two networks of PSMNet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Architecture {
    /// Three hourglasses of 3D convolutions, one after the other: `stackhourglass`.
    StackHourglass,
    /// Five residual blocks of 3D convolutions: `basic`.
    Basic,
}

impl fmt::Display for Architecture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::StackHourglass => "stackhourglass",
            Self::Basic => "basic",
        })
    }
}

/// What is wrong with one tensor.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Problem {
    /// The architecture has it, the tensors do not.
    Missing {
        /// Its name, without `module.`.
        name: String,
        /// The shape it must have.
        wanted: Vec<usize>,
    },
    /// The tensors have it, the architecture does not.
    Extra {
        /// Its name, without `module.`.
        name: String,
    },
    /// It has another shape.
    Shape {
        /// Its name, without `module.`.
        name: String,
        /// The shape that was given.
        found: Vec<usize>,
        /// The shape it must have.
        wanted: Vec<usize>,
    },
    /// A value that no weight can have: infinite, not a number, or a variance below 0.
    Value {
        /// Its name, without `module.`.
        name: String,
        /// The value that was given.
        found: f32,
        /// What it must be.
        wanted: &'static str,
    },
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing { name, wanted } => write!(f, "{name} {wanted:?} is missing"),
            Self::Extra { name } => write!(f, "{name} is unknown"),
            Self::Shape { name, found, wanted } => write!(f, "{name} is {found:?}, but must be {wanted:?}"),
            Self::Value { name, found, wanted } => write!(f, "{name} has the value {found}, but must be {wanted}"),
        }
    }
}

/// A name without the prefix of a model that was trained on several devices.
pub(super) fn short(name: &str) -> &str {
    name.strip_prefix("module.").unwrap_or(name)
}

/// Whether a tensor is of no use for inference: batch normalisation counts its batches.
pub(super) fn counter(name: &str) -> bool {
    name.ends_with(".num_batches_tracked")
}

impl Architecture {
    /// Both.
    pub const ALL: [Self; 2] = [Self::StackHourglass, Self::Basic];

    /// The list of operations, in the order of computation; the last one makes the disparities.
    pub fn operations(self) -> Vec<Operation> {
        match self {
            Self::StackHourglass => stack_hourglass(),
            Self::Basic => basic(),
        }
    }

    /// The names and shapes of all tensors of a published file, without `module.` and without the counters
    /// `num_batches_tracked`. Weights of transposed convolutions have their inputs first.
    pub fn tensors(self) -> BTreeMap<String, Vec<usize>> {
        let operations = self.operations();
        let mut tensors = BTreeMap::new();
        for operation in &operations {
            let (Some(parameters), Some(mut shape)) = (&operation.parameters, operation.weights(&operations)) else {
                continue;
            };
            if operation.kind == Kind::TransposedConv3d {
                shape.swap(0, 1);
            }
            tensors.insert(format!("{}.weight", parameters.convolution), shape);
            for part in ["weight", "bias", "running_mean", "running_var"] {
                if let Some(norm) = &parameters.norm {
                    tensors.insert(format!("{norm}.{part}"), vec![operation.channels]);
                }
            }
        }
        tensors
    }

    /// The architecture that tensors with these names are of, if they look like one: `basic` has `classify`, and
    /// `stackhourglass` has hourglasses or `classif1` to `classif3`. Names may begin with `module.`.
    pub fn of<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<Self> {
        let mut found = None;
        for name in names.into_iter().map(short) {
            let stacked = ["classif1.", "classif2.", "classif3.", "dres2.conv", "dres3.conv", "dres4.conv"];
            if stacked.iter().any(|start| name.starts_with(start)) {
                return Some(Self::StackHourglass);
            }
            if ["classify.", "dres2.0.", "dres2.2."].iter().any(|start| name.starts_with(start)) {
                found = Some(Self::Basic);
            }
        }
        found
    }

    /// All that keeps tensors from being this network, by name.
    pub fn problems(self, tensors: &Tensors) -> Vec<Problem> {
        let wanted = self.tensors();
        let given: BTreeMap<&str, _> = tensors.iter().map(|(name, tensor)| (short(name), tensor)).collect();
        let mut problems = Vec::new();
        for (name, wanted) in &wanted {
            let name = name.clone();
            let Some(tensor) = given.get(name.as_str()) else {
                problems.push(Problem::Missing { name, wanted: wanted.clone() });
                continue;
            };
            let variance = name.ends_with(".running_var");
            let odd = tensor.data().iter().find(|&&value| !value.is_finite() || variance && value < 0.0);
            if tensor.shape() != wanted {
                problems.push(Problem::Shape { name, found: tensor.shape().to_vec(), wanted: wanted.clone() });
            } else if let Some(&found) = odd {
                let wanted = if variance { "0 or more" } else { "finite" };
                problems.push(Problem::Value { name, found, wanted });
            }
        }
        let unknown = given.keys().filter(|name| !wanted.contains_key(**name) && !counter(name));
        problems.extend(unknown.map(|&name| Problem::Extra { name: name.to_owned() }));
        problems
    }

    /// The same as an error, which names the first few.
    pub(super) fn check(self, tensors: &Tensors) -> Result<(), Error> {
        const NAMED: usize = 5;
        let problems = self.problems(tensors);
        if problems.is_empty() {
            return Ok(());
        }
        let named: Vec<String> = problems.iter().take(NAMED).map(ToString::to_string).collect();
        let more = match problems.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!("; and {more} more"),
        };
        Err(Error::Network(format!(
            "these are no weights of PSMNet's {self}: {}{more}; give a whole file as published or as the training wrote it",
            named.join("; ")
        )))
    }
}
