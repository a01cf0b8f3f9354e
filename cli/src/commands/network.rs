//! `--weights`: the network of all settings that compute with one.

use crate::args::NetworkArgs;
use crate::terminal::message;
use anyhow::{Result, bail};
use gpu_stereo::{FeatureNetwork, Method, Network, Params};

/// Gives the network to all settings with `--method psmnet`, or to those whose cost compares features. The file is read once, and only if
/// it is needed.
pub fn give<'a>(args: &NetworkArgs, all: impl IntoIterator<Item = &'a mut Params>) -> Result<()> {
    let (with, others): (Vec<_>, Vec<_>) = all.into_iter().partition(|params| matches!(params.method, Method::Psmnet));
    let (learned, without): (Vec<_>, Vec<_>) = others.into_iter().partition(|params| params.takes_features());
    let Some(path) = &args.weights else {
        if with.is_empty() {
            return Ok(()); // features have a network of the library
        }
        bail!(
            "--method psmnet needs the weights of a network; give --weights FILE (docs/NETWORKS.md says where to get them)"
        );
    };
    match (with.is_empty(), learned.is_empty()) {
        (false, false) => bail!(
            "--weights {path:?} is for --method psmnet or for the cost {}, not both in one run; run them one after the other",
            learned[0].cost
        ),
        (false, true) => {
            let network = Network::load(path)?;
            with.into_iter().for_each(|params| params.network = Some(network.clone()));
        }
        (true, false) => {
            let network = FeatureNetwork::load(path)?;
            learned.into_iter().for_each(|params| params.features = Some(network.clone()));
        }
        (true, true) => {
            let Some(params) = without.first() else { return Ok(()) };
            message(&format!("note: --weights has no effect with --method {} --cost {}", params.method, params.cost));
        }
    }
    Ok(())
}
