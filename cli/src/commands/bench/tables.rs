//! The sets of a data set, and the tables of scenes and sets.

use super::scene::SceneReport;
use crate::terminal::{Evaluation, percent, pixels, table};
use gpu_stereo::evaluation::Scores;
use serde::Serialize;

/// A set with a variant: the mean of its scenes, and all their pixels together.
#[derive(Serialize)]
pub struct SetReport {
    pub set: String,
    pub variant: String,
    pub region: &'static str,
    pub scenes: usize,
    pub mean: Evaluation,
    pub pooled: Evaluation,
    pub frame_ms: f64,
}

const REGIONS: [&str; 2] = ["all", "noc"];

/// Every set with every variant, in the order in which they came.
pub fn sets(scenes: &[SceneReport]) -> Vec<SetReport> {
    let mut keys: Vec<(&str, &str)> = Vec::new();
    for scene in scenes {
        let key = (scene.set.as_str(), scene.variant.as_str());
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    let mut sets = Vec::new();
    for (set, variant) in keys {
        for (region, name) in REGIONS.into_iter().enumerate() {
            let of_set = scenes.iter().filter(|scene| (scene.set.as_str(), scene.variant.as_str()) == (set, variant));
            let scored: Vec<_> = of_set.filter_map(|scene| Some((scene, scene.scores[region].as_ref()?))).collect();
            if scored.is_empty() {
                continue;
            }
            let mut pooled = Scores::default();
            scored.iter().for_each(|(_, scores)| pooled.add(scores));
            let each: Vec<_> = scored.iter().map(|(_, scores)| Evaluation::from(*scores)).collect();
            let ms = scored.iter().map(|(scene, _)| scene.frame_ms.median).sum::<f64>();
            sets.push(SetReport {
                set: set.into(),
                variant: variant.into(),
                region: name,
                scenes: scored.len(),
                mean: Evaluation::mean(&each),
                pooled: Evaluation::from(&pooled),
                frame_ms: ms / scored.len() as f64,
            });
        }
    }
    sets
}

/// Columns of an evaluation.
const COLUMNS: [&str; 8] = ["density", "bad-1", "bad-2", "bad-2 of valid", "average", "A95", "D1-est", "D1-all"];

fn columns(e: &Evaluation) -> [String; 8] {
    [
        percent(e.density),
        percent(e.bad_1),
        percent(e.bad_2),
        percent(e.bad_2_of_valid),
        pixels(e.average_error),
        pixels(e.a95),
        percent(e.d1_est),
        percent(e.d1_all),
    ]
}

/// A row for each scene with each variant.
pub fn scene_table(scenes: &[SceneReport]) -> String {
    let [a, b, c, d, e, f, g, h] = COLUMNS;
    let header = ["scene", "variant", "region", "disp", a, b, c, d, e, f, g, h, "ms"];
    let mut rows = Vec::new();
    for scene in scenes {
        let name = format!("{}/{}", scene.set, scene.scene);
        let row = |region: &str, cells: [String; 8]| {
            let [a, b, c, d, e, f, g, h] = cells;
            let (disp, ms) = (scene.disparities.to_string(), format!("{:.1}", scene.frame_ms.median));
            [name.clone(), scene.variant.clone(), region.into(), disp, a, b, c, d, e, f, g, h, ms]
        };
        let evaluations = [&scene.evaluation, &scene.evaluation_noc];
        let scored = REGIONS.iter().zip(evaluations).filter_map(|(region, e)| Some(row(region, columns(e.as_ref()?))));
        let before = rows.len();
        rows.extend(scored);
        if rows.len() == before {
            rows.push(row("no truth", [(); 8].map(|()| "-".into())));
        }
    }
    table(header, rows, 3..13)
}

/// A row for each set with each variant; empty if there is none.
pub fn set_table(sets: &[SetReport]) -> String {
    if sets.is_empty() {
        return String::new();
    }
    let [a, b, c, d, e, f, g, h] = COLUMNS;
    let header = ["set", "variant", "region", "scenes", a, b, c, d, e, f, g, h, "D1-all pooled", "ms"];
    let rows = sets.iter().map(|set| {
        let [a, b, c, d, e, f, g, h] = columns(&set.mean);
        let (scenes, pooled, ms) = (set.scenes.to_string(), percent(set.pooled.d1_all), format!("{:.1}", set.frame_ms));
        [set.set.clone(), set.variant.clone(), set.region.into(), scenes, a, b, c, d, e, f, g, h, pooled, ms]
    });
    table(header, rows, 3..14)
}
