//! Writes the Markov random field of a pair and a method's labels of it, for programs that minimise the same energy:
//!
//!     cargo run --release --example random_field -- LEFT RIGHT DIR --disp 16 --set method=sgm
//!
//! DIR gets `cost.raw`, the quantised cost, a byte for each row, column and disparity (the last runs fastest); `gray.raw`, a
//! byte for each pixel of the left image, by which the smoothness is lowered at edges; and `labels.raw`, 16 bits a pixel,
//! little endian. docs/ALGORITHMS.md says what they are ("energy"). On stdout: width, height, disparities, data and smoothness.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Parser;
use gpu_stereo::files::images::{Bits, ImagePair, read_pair};
use gpu_stereo::reference::{self, Channel};
use gpu_stereo::{Params, reference::cost_columns};

/// The Markov random field of a pair, and the labels that a method finds in it.
#[derive(Parser)]
struct Options {
    /// The left image
    left: PathBuf,
    /// The right image
    right: PathBuf,
    /// The folder that is written to
    folder: PathBuf,
    /// Number of disparities
    #[arg(long, value_name = "N")]
    disp: u32,
    /// A setting by its name on the command line, as in method=bp; may be given several times
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    set: Vec<(String, String)>,
}

fn setting(text: &str) -> Result<(String, String), &'static str> {
    let (name, value) = text.split_once('=').ok_or("NAME=VALUE is needed, such as method=bp")?;
    Ok((name.into(), value.into()))
}

fn main() -> Result<()> {
    let Options { left, right, folder, disp, set } = Options::parse();
    let mut params = Params::from_options(disp, set.iter().map(|(name, value)| (name.as_str(), value.as_str())))?;
    params.labels = true;
    let ImagePair { left, right, .. } = read_pair(&left, &right, Bits::Auto)?;

    let labels = reference::compute_all(&left, &right, &params)?.labels.context("there are no labels")?;
    let energy = reference::energy(&left, &right, &labels, &params)?;
    let sides =
        [&left, &right].map(|image| reference::images(image, &params).prefiltered(&params).descriptors(&params));
    let columns = cost_columns(&sides[0], &sides[1], &labels.table, &params);
    let cost = reference::matching_cost(&columns, &params);
    let gray = reference::gray(&left, Channel::Luma);

    fs::create_dir_all(&folder).with_context(|| format!("{}: cannot be made", folder.display()))?;
    let bytes: Vec<u8> = labels.data.iter().flat_map(|label| label.to_le_bytes()).collect();
    for (name, bytes) in [("cost.raw", &cost.data), ("gray.raw", &gray.data), ("labels.raw", &bytes)] {
        let path = folder.join(name);
        fs::write(&path, bytes).with_context(|| format!("{}: cannot be written", path.display()))?;
    }
    println!("{} {} {} {} {}", labels.width, labels.height, cost.disparities, energy.data, energy.smoothness);
    Ok(())
}
