//! `calib`: what is understood of a calibration, and both fields of view.

mod fields;
mod report;
mod understood;

use super::outcome::Outcome;
use crate::args::CalibArgs;
use crate::engine::output_files;
use crate::terminal::{self, message};
use anyhow::{Context as _, Result};
use gpu_stereo::files::calibration::{Calibration, Source};
use gpu_stereo::files::outputs;
use report::CalibReport;
use understood::Understood;

/// Prints what is understood, and draws the fields of view.
pub fn run(args: &CalibArgs) -> Result<Outcome> {
    let inputs: Vec<_> =
        [Some(&args.file), args.right.as_ref()].into_iter().flatten().map(|path| path.as_path()).collect();
    let output = args.output.as_deref().map(|path| output_files::resolve_fields(path, &inputs)).transpose()?;
    let understood = understand(args)?;
    let mut report = CalibReport::of(&understood)?;
    if let Some(output) = &output {
        let (size, fitted) = understood
            .fitted
            .as_ref()
            .context("--output needs the size of the images, which the file does not have; give it with --size WxH")?;
        let lenses = fitted.lenses.context(
            "the pairs of this calibration are rectified, so that both fields of view are the whole image; drop --output",
        )?;
        outputs::write_bytes(output, &fields::picture(*size, fitted, lenses)?)?;
        report.outputs.push(output.path.clone());
    }
    if args.json {
        terminal::print_json(&report)?;
    } else {
        terminal::print(&report.text()?)?;
        report.notes.iter().for_each(|note| message(&format!("note: {note}")));
    }
    Ok(Outcome::Done)
}

/// Reads it as of cameras that are to be rectified, or else as of a rectified pair.
fn understand(args: &CalibArgs) -> Result<Understood> {
    let source = Source::read(&args.file)?;
    let right = args.right.as_deref().map(Source::read).transpose()?;
    let read = |lenses| Calibration::of(&source, right.as_ref(), args.reading.reading(lenses));
    let named = || format!("{:?}", args.file);
    let mut notes = Vec::new();
    let (calibration, lenses) = match read(true) {
        Ok(calibration) => (calibration, true),
        Err(error) => {
            let chooses = args.reading.alpha.is_some() || args.reading.rectified_size.is_some();
            match read(false) {
                Ok(calibration) if !chooses => {
                    if source.has_lenses() {
                        notes.push(format!("it cannot be given with --rectify: {error}"));
                    }
                    (calibration, false)
                }
                _ => return Err(error).with_context(named),
            }
        }
    };
    let size = args.size.or(calibration.image_size());
    let description = calibration.describe(args.size).with_context(named)?;
    if let (Some(name), None) = (&description.resolution, args.size) {
        notes.push(format!("it is of several resolutions, and this is {name}; give --size WxH for that of the images"));
    }
    let fitted = match size {
        Some([width, height]) => Some(([width, height], calibration.fit(width, height).with_context(named)?)),
        None => {
            if lenses {
                notes.push("the file has no size of the images; give --size WxH for the rectified cameras".into());
            }
            None
        }
    };
    if let Some((_, fitted)) = &fitted {
        notes.extend(calibration.doubt(&fitted.camera));
        if fitted.vertical {
            notes.push(
                "the cameras lie one above the other: LEFT is taken for the upper one, and the pair is turned".into(),
            );
        }
    }
    Ok(Understood { description, lenses, fitted, notes })
}
