//! The report of `calib`, as a table and as JSON.

use super::understood::Understood;
use crate::terminal::{self, table};
use anyhow::Result;
use gpu_stereo::files::calibration::{DescribedCamera, Fitted, turn_of};
use gpu_stereo::{Camera, Params, Rectification, reference};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

/// What is understood; `--json` prints it as it is.
#[derive(Serialize)]
pub struct CalibReport {
    kind: &'static str,
    /// Columns and rows of the images.
    size: Option<[u32; 2]>,
    resolution: Option<String>,
    /// Whether its pairs are rectified: the file is for `--calib`, else for `--rectify`.
    rectified: bool,
    vertical: Option<bool>,
    unit: Option<&'static str>,
    baseline_m: Option<f64>,
    translation_m: Option<[f64; 3]>,
    rotation_degrees: Option<f64>,
    cameras: Vec<CameraRow>,
    rectified_cameras: Option<RectifiedCameras>,
    /// What is doubtful or missing.
    pub notes: Vec<String>,
    /// The picture.
    #[serde(serialize_with = "terminal::paths")]
    pub outputs: Vec<PathBuf>,
}

/// A camera as it was calibrated.
#[derive(Serialize)]
struct CameraRow {
    side: &'static str,
    focal_px: [f64; 2],
    principal_point_px: [f64; 2],
    lens: &'static str,
    numbers: Vec<f64>,
    /// The angle to the rectified camera.
    turned_degrees: Option<f64>,
    /// The share of the rectified image that it sees.
    content: Option<f64>,
}

/// The rectified cameras.
#[derive(Serialize)]
struct RectifiedCameras {
    /// Columns and rows, where the size of the images is known.
    size: Option<[u32; 2]>,
    focal_px: f64,
    cx_px: f64,
    cy_px: f64,
    doffs_px: f64,
    baseline_m: f64,
    /// What a disparity of 1 px becomes, in metres.
    depth_at_1_px_m: f64,
}

impl CalibReport {
    /// Of what is understood.
    pub fn of(understood: &Understood) -> Result<Self> {
        let Understood { description, lenses, fitted, notes } = understood;
        let fit = fitted.as_ref().map(|(_, fitted)| fitted);
        let seen = fitted.as_ref().map(|(size, fitted)| content(*size, fitted)).transpose()?.flatten();
        let row = |(i, camera): (usize, &DescribedCamera)| CameraRow {
            side: side(i, fit.is_some_and(|fit| fit.vertical)),
            focal_px: camera.focal,
            principal_point_px: camera.principal_point,
            lens: camera.model.unwrap_or("none"),
            numbers: camera.lens.clone(),
            turned_degrees: fit.and_then(|fit| fit.lenses).map(|lenses| turn_of(&lenses[i])),
            content: seen.map(|seen| seen[i]),
        };
        let camera = fit.map(|fit| fit.camera).or(description.rectified);
        let rectified = camera.map(|Camera { focal, baseline, doffs, cx, cy, .. }| RectifiedCameras {
            size: fit.map(|fit| fit.size),
            focal_px: focal,
            cx_px: cx,
            cy_px: cy,
            doffs_px: doffs,
            baseline_m: baseline,
            depth_at_1_px_m: focal * baseline / (1.0 + doffs),
        });
        Ok(Self {
            kind: description.kind,
            size: fitted.as_ref().map(|(size, _)| *size).or(description.size),
            resolution: description.resolution.clone(),
            rectified: !lenses,
            vertical: fit.map(|fit| fit.vertical),
            unit: description.unit,
            baseline_m: camera.map(|camera| camera.baseline).or(description.distance()),
            translation_m: description.translation,
            rotation_degrees: description.rotation,
            cameras: description.cameras.iter().enumerate().map(row).collect(),
            rectified_cameras: rectified,
            notes: notes.clone(),
            outputs: Vec::new(),
        })
    }

    /// For people.
    pub fn text(&self) -> Result<String> {
        let mut text = String::new();
        let mut line = |name: &str, value: String| writeln!(text, "{name:<11}{value}");
        line("kind", self.kind.into())?;
        let pairs = if self.rectified {
            "rectified; give it with --calib"
        } else {
            "as they were taken; give it with --rectify"
        };
        line("pairs", pairs.into())?;
        if let Some([width, height]) = self.size {
            let name = self.resolution.as_ref().map(|name| format!(" ({name})")).unwrap_or_default();
            line("size", format!("{width} x {height}{name}"))?;
        }
        if let Some(baseline) = self.baseline_m {
            let unit = self.unit.map(|unit| format!(", read in {unit}")).unwrap_or_default();
            let way = if self.vertical == Some(true) { ", one above the other" } else { "" };
            line("baseline", format!("{} m{unit}{way}", short(baseline)))?;
        }
        if let Some(translation) = self.translation_m {
            line("T", format!("{} m", several(&translation)))?;
        }
        if let Some(degrees) = self.rotation_degrees {
            line("rotation", format!("{} degrees between the cameras", short(degrees)))?;
        }
        if let Some(rectified) = &self.rectified_cameras {
            let RectifiedCameras { size, focal_px, cx_px, cy_px, doffs_px, depth_at_1_px_m, .. } = rectified;
            line(
                "rectified",
                format!(
                    "{}focal length {} px, principal point {} {}, doffs {} px",
                    size.map(|[width, height]| format!("{width} x {height}, ")).unwrap_or_default(),
                    short(*focal_px),
                    short(*cx_px),
                    short(*cy_px),
                    short(*doffs_px)
                ),
            )?;
            if depth_at_1_px_m.is_finite() {
                line("depth", format!("{} m at a disparity of 1 px", short(*depth_at_1_px_m)))?;
            }
        }
        for path in &self.outputs {
            line("written", terminal::name(path).to_string())?;
        }
        if let [left, right] = &self.cameras[..] {
            let row = |name: &str, value: &dyn Fn(&CameraRow) -> String| [name.to_string(), value(left), value(right)];
            let degrees = |camera: &CameraRow| camera.turned_degrees.map_or("-".into(), short);
            let share = |camera: &CameraRow| camera.content.map_or("-".into(), |share| format!("{:.1}", 100.0 * share));
            let rows = [
                row("focal length px", &|camera| several(&camera.focal_px)),
                row("principal point px", &|camera| several(&camera.principal_point_px)),
                row("lens", &|camera| camera.lens.into()),
                row("its numbers", &|camera| several(&camera.numbers)),
                row("turned by degrees", &degrees),
                row("content of the rectified image %", &share),
            ];
            text += &table(["camera", left.side, right.side], rows, 1..3);
        }
        Ok(text)
    }
}

fn side(i: usize, vertical: bool) -> &'static str {
    match (i, vertical) {
        (0, false) => "left",
        (0, true) => "upper",
        (_, false) => "right",
        (_, true) => "lower",
    }
}

/// The share of the rectified images that each camera sees.
fn content(size: [u32; 2], fitted: &Fitted) -> Result<Option<[f64; 2]>> {
    let Some(lenses) = fitted.lenses else { return Ok(None) };
    let mut params = Params::sgm(1);
    params.rectify = Some(Rectification::of_size(size, fitted.size, lenses)?);
    let content = reference::Content::new(&params, size[0], size[1]);
    let share = |side: usize| {
        content.as_ref().map_or(1.0, |content| {
            let all = &content.sides[side].data;
            all.iter().filter(|has| **has).count() as f64 / all.len() as f64
        })
    };
    Ok(Some([share(0), share(1)]))
}

/// Six digits; what is next to nothing is 0.
fn short(value: f64) -> String {
    if value.abs() < 1e-9 || !value.is_finite() {
        return format!("{}", if value.is_finite() { 0.0 } else { value });
    }
    let scale = 10f64.powi(5 - value.abs().log10().floor() as i32);
    format!("{}", (value * scale).round() / scale)
}

fn several(values: &[f64]) -> String {
    if values.is_empty() { "-".into() } else { values.iter().map(|value| short(*value)).collect::<Vec<_>>().join(" ") }
}
