//! OpenEXR: a file with one channel of floats, or one whose other channels are colours of the same values.

use super::samples::{Samples, ensure_pixels};
use crate::files::error::{Result, bail, ensure, error};
use exr::prelude::{FlatSamples, ReadChannels as _, ReadLayers as _, read};
use std::io::Cursor;

/// The channels that hold a disparity or a depth beside others, in the order in which they are looked for.
const NAMES: [&str; 6] = ["disparity", "disp", "depth", "z", "y", "v"];

/// The channel of the first layer.
pub fn exr(bytes: &[u8]) -> Result<(u32, u32, Samples)> {
    let damaged = |error: exr::error::Error| {
        let told: String = error.to_string().chars().take(200).collect();
        error!("it is damaged, cut short or of a rare kind ({told}): save it again")
    };
    // The library allocates what the header declares.
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(damaged)?;
    for header in &meta.headers {
        let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
        ensure_pixels(side(header.layer_size.x()), side(header.layer_size.y()))?;
        ensure!(!header.deep, "it has several samples a pixel (deep data), but one is needed; flatten it");
        let channels = header.channels.list.len();
        ensure!(channels <= 16, "it has {channels} channels, but at most 16 are read; save the one of the map");
    }
    let reader = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = reader.non_parallel().from_buffered(Cursor::new(bytes)).map_err(damaged)?;
    let layer = image.layer_data;
    let channels = &layer.channel_data.list;
    let named = |name: &str| channels.iter().find(|channel| channel.name.to_string().eq_ignore_ascii_case(name));
    let found = match &channels[..] {
        [one] => Some(one),
        _ => NAMES.into_iter().find_map(named),
    };
    // As OpenCV and others save one channel: red, green and blue alike.
    let bits =
        |name: &str| named(name).map(|c| numbers(&c.sample_data).into_iter().map(f64::to_bits).collect::<Vec<_>>());
    let red = named("R").filter(|_| ["G", "B"].iter().all(|other| bits(other) == bits("R")));
    let Some(channel) = found.or(red) else {
        let names: Vec<_> = channels.iter().map(|channel| channel.name.to_string()).collect();
        bail!("it has the channels {}, but one of a map is needed; save that one", names.join(", "));
    };
    let (width, height) = (layer.size.x() as u32, layer.size.y() as u32);
    Ok((width, height, Samples::Float(numbers(&channel.sample_data))))
}

fn numbers(samples: &FlatSamples) -> Vec<f64> {
    match samples {
        FlatSamples::F16(values) => values.iter().map(|v| f64::from(v.to_f32())).collect(),
        FlatSamples::F32(values) => values.iter().copied().map(f64::from).collect(),
        FlatSamples::U32(values) => values.iter().copied().map(f64::from).collect(),
    }
}
