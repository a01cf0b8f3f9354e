//! `--list-adapters`: the adapters, the best first.

use super::outcome::Outcome;
use crate::terminal::{self, message, table};
use anyhow::Result;
use gpu_stereo::backend;
use gpu_stereo::wgpu::Adapter;
use serde::Serialize;

/// An adapter; `--json` prints it as it is.
#[derive(Serialize)]
struct Listed {
    index: usize,
    name: String,
    backend: String,
    driver: String,
    kind: &'static str,
}

/// Prints the adapters.
pub fn run(json: bool) -> Result<Outcome> {
    backend::ensure_environment(&mut |text| message(&format!("note: {text}")))?;
    let adapters = backend::adapters()?;
    let infos = adapters.iter().map(Adapter::get_info).enumerate();
    let listed = infos.map(|(index, info)| Listed {
        index,
        backend: info.backend.to_string(),
        driver: backend::driver(&info),
        kind: backend::kind(info.device_type),
        name: info.name,
    });
    let listed: Vec<_> = listed.collect();
    if listed.is_empty() {
        let why = backend::why_none();
        message(&format!("note: there is no adapter{why}; install a Vulkan driver, or compute with --backend cpu"));
    }
    if json {
        terminal::print_json(&listed)?;
    } else {
        let rows = listed.into_iter().map(|a| [a.index.to_string(), a.name, a.backend, a.driver, a.kind.to_owned()]);
        terminal::print(&table(["index", "name", "backend", "driver", "kind"], rows, 0..0))?;
    }
    Ok(Outcome::Done)
}
