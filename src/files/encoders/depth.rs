//! Depths as samples: millimetres or metres.

use crate::DepthMap;

/// Samples of 16 bits in millimetres, 0 where there is no depth; and how many depths are too large for them, and are 0, too.
pub fn millimetres(depth: &DepthMap) -> (Vec<u16>, usize) {
    let of = |&micrometres: &u32| match (u64::from(micrometres) + 500) / 1000 {
        _ if micrometres == DepthMap::NONE => 0,
        nearest => u16::try_from(nearest).unwrap_or(0).max(u16::from(nearest == 0)),
    };
    let samples: Vec<u16> = depth.data.iter().map(of).collect();
    let lost = samples.iter().zip(&depth.data).filter(|(sample, depth)| **sample == 0 && **depth != DepthMap::NONE);
    let lost = lost.count();
    (samples, lost)
}

/// Metres, NaN where there is no depth.
pub fn metres(depth: &DepthMap, none: f32) -> Vec<f32> {
    let of = |&value: &u32| if value == DepthMap::NONE { none } else { (f64::from(value) * 1e-6) as f32 };
    depth.data.iter().map(of).collect()
}
