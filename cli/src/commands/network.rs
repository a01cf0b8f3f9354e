//! `--weights`: the network of all settings that compute with one.

use crate::args::NetworkArgs;
use crate::terminal::message;
use anyhow::{Result, bail};
use gpu_stereo::{Method, Network, Params};

/// Gives the network to all settings with `--method psmnet`. The file is read once, and only if it is needed.
pub fn give<'a>(args: &NetworkArgs, all: impl IntoIterator<Item = &'a mut Params>) -> Result<()> {
    let (with, without): (Vec<_>, Vec<_>) = all.into_iter().partition(|params| matches!(params.method, Method::Psmnet));
    match (&args.weights, with.is_empty()) {
        (None, true) => {}
        (None, false) => bail!(
            "--method psmnet needs the weights of a network; give --weights FILE (docs/NETWORKS.md says where to get them)"
        ),
        (Some(_), true) => {
            let method = without.first().map(|params| params.method.to_string()).unwrap_or_default();
            message(&format!("note: --weights has no effect with --method {method}"));
        }
        (Some(path), false) => {
            let network = Network::load(path)?;
            with.into_iter().for_each(|params| params.network = Some(network.clone()));
        }
    }
    Ok(())
}
