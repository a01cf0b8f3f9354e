//! Run: read the pair, compute, check, write.

use super::report::Report;
use super::resolve::Job;
use super::shaders;
use crate::commands::energy::{self, EnergyReport};
use crate::engine::compute::{self, Computed, RangeFinder};
use crate::engine::{diagnosis, images, output_files};
use crate::terminal::{Evaluation, Share, warnings};
use anyhow::Result;
use gpu_stereo::evaluation::FloatMap;
use gpu_stereo::files::encoders::{Format, Maps, ensure_range};
use gpu_stereo::files::images::ImagePair;
use gpu_stereo::files::outputs;
use gpu_stereo::files::truth::{Truth, TruthFile};
use gpu_stereo::{Camera, Image, Matched, Params};
use std::time::Instant;

/// Does the job.
pub fn run(job: &Job) -> Result<Report> {
    let views = images::read_pair(&job.left, &job.right, &job.input)?;
    let (samples, turned) = (views.samples(), views.turns());
    views.doubts.iter().for_each(|doubt| warnings::warn(doubt));
    let ImagePair { left, right, bits, .. } = views;
    outputs::ensure_size(&job.outputs, left.width(), left.height())?;
    let given = [left.width(), left.height()];
    let read = |truth: &TruthFile| job.cameras.truth(given, |size| Ok(truth.read(size, &job.left)?));
    let truth = job.truth.as_ref().map(read).transpose()?;
    truth.iter().flat_map(|truth| &truth.doubts).for_each(|doubt| warnings::warn(doubt));
    let (mut params, camera) = params_for(job, &left)?;
    find_range(job, [&left, &right], &mut params)?;
    let (params, camera) = (&params, &camera);
    let start = Instant::now();
    let open = |params: &Params| compute::open(&job.device, job.needs_adapter, &left, params);
    let (engine, params) = &energy::opened(params, open)?;
    if let Some(folder) = &job.shaders {
        shaders::write(folder, &engine.shaders())?;
    }
    // Stage times come from the frames that are reported, so that stages and transfers add up to the frame.
    let timed = job.timings || job.json;
    let bar = Share::new(&format!("--method {}", params.method), job.quiet || params.network.is_none());
    let show = |share| bar.show(share);
    let computed = compute::frames(engine, &left, &right, params, timed, job.repeat, &show);
    bar.finish();
    let Computed { mut matched, first, times, stages } = computed?;
    job.cameras.cut(&mut matched);
    let first_frame_ms = (first - start).as_secs_f64() * 1e3;
    if let Some(finding) = diagnosis::finding(&left, &right, params)? {
        warnings::warn(&finding.to_string());
    }

    let energy = EnergyReport::new(&left, &right, &matched, params)?;
    let check = if job.check { Some(compute::check(engine, &left, &right, params)?) } else { None };
    let passed = check.iter().flatten().all(|stage| stage.mismatches == 0);
    let evaluation =
        if passed { write(job, (params, camera.as_ref()), [&left, &right], &matched, truth.as_ref())? } else { None };
    let outputs = if passed { job.outputs.iter().map(|output| output.path.clone()).collect() } else { Vec::new() };
    Ok(Report {
        names: engine.names([params]).into(),
        width: matched.map.width,
        height: matched.map.height,
        bits,
        samples,
        turned,
        min_disparity: params.min_disparity,
        disparities: params.disparities,
        camera: camera.map(Into::into),
        valid: matched.map.valid_fraction(),
        frame_ms: times,
        first_frame_ms,
        stages,
        energy,
        peak_device_bytes: engine.device_bytes(),
        evaluation,
        check: check.map(|stages| stages.into_iter().map(Into::into).collect()),
        warnings: warnings::all(),
        outputs,
    })
}

/// Sets the range of the settings, if it is left to the pair.
fn find_range(job: &Job, pair: [&Image; 2], params: &mut Params) -> Result<()> {
    if !job.range.is_found() {
        return Ok(());
    }
    let coarse = RangeFinder::new(&job.device).coarse(pair, params)?;
    let held = output_files::held(job.outputs.iter().map(|output| output.format));
    coarse.set(job.range, held.as_ref(), params)?.iter().for_each(|doubt| warnings::warn(doubt));
    Ok(job.outputs.iter().try_for_each(|output| ensure_range(output.format, &output.path, params))?)
}

/// The settings of the job for images of this size, and the rectified cameras, if they are known.
fn params_for(job: &Job, image: &Image) -> Result<(Params, Option<Camera>)> {
    let mut params = job.params.clone();
    params.masks = images::reported(job.masks.read_for(image)?);
    let camera = job.cameras.fit(&mut params, [image.width(), image.height()], job.depth)?;
    Ok((params, camera))
}

/// Scores the map where there is a truth, and writes all files.
fn write(
    job: &Job,
    (params, camera): (&Params, Option<&Camera>),
    pair: [&Image; 2],
    matched: &Matched,
    truth: Option<&Truth>,
) -> Result<Option<Evaluation>> {
    let (mut evaluation, mut errors) = (None, None);
    if let Some(truth) = truth {
        let estimate = FloatMap::from(&matched.map);
        evaluation = Some(Evaluation::from(&truth.score(&estimate)?));
        if job.outputs.iter().any(|output| output.format == Format::ErrorMap) {
            errors = Some(truth.error_picture(&estimate)?);
        }
    }
    let images = output_files::images_for(&job.outputs, pair.map(Some), params)?;
    let images = images.each_ref().map(Option::as_deref);
    let maps = Maps { errors: errors.as_ref(), images, camera, ..Maps::all(matched, params) };
    output_files::write_all(&job.outputs, &maps)?;
    Ok(evaluation)
}
