//! KITTI's calib files, and DrivingStereo's: 3 x 4 projection matrices of the rectified cameras, a line each, as `P0` to `P3`,
//! `P_rect_00` to `P_rect_03`, `P_rect_101` and `P_rect_103`, or without names.

use crate::files::calibration::cameras::{Cameras, Found};
use crate::files::calibration::content::tree::{number, whole};
use crate::files::calibration::reading::{KittiPair, Reading, Unit};
use crate::files::calibration::rectified::of_projections;
use crate::files::error::{Context as _, Result, bail, ensure};
use std::collections::BTreeMap;

pub const NAME: &str = "KITTI or DrivingStereo (calib files)";

/// The number of the camera whose projection has this name.
fn camera_of(key: &str) -> Option<u32> {
    let digits = key.strip_prefix("P_rect_").or_else(|| key.strip_prefix('P'))?;
    digits.parse().ok().filter(|_| digits.bytes().all(|byte| byte.is_ascii_digit()))
}

/// A line `P0: 7.2e+02 0 ..`, or nothing but lines of 12 numbers.
pub fn is(text: &str) -> bool {
    let projection = |line: &str| {
        line.split_once(':').is_some_and(|(key, values)| {
            camera_of(key.trim()).is_some() && values.split_whitespace().filter(|word| number(word).is_ok()).count() > 1
        })
    };
    text.lines().any(projection) || unnamed(text).is_some()
}

fn unnamed(text: &str) -> Option<Vec<Vec<f64>>> {
    let matrix = |line: &str| {
        let numbers: Vec<f64> = line.split_whitespace().map(|word| number(word).ok()).collect::<Option<_>>()?;
        (numbers.len() == 12).then_some(numbers)
    };
    text.lines().filter(|line| !line.trim().is_empty()).map(matrix).collect()
}

pub fn read(text: &str, reading: Reading) -> Result<Found> {
    let (mut projections, mut sizes) = (BTreeMap::new(), BTreeMap::new());
    for (camera, numbers) in unnamed(text).into_iter().flatten().enumerate() {
        projections.insert(camera as u32, numbers);
    }
    for (key, values) in text.lines().filter_map(|line| line.split_once(':')) {
        let key = key.trim();
        let numbers = || -> Result<Vec<f64>> {
            values.split_whitespace().map(number).collect::<Result<_>>().with_context(|| format!("its {key}"))
        };
        if let Some(camera) = camera_of(key) {
            ensure!(
                projections.insert(camera, numbers()?).is_none(),
                "it has two lines {key}: ..; remove the one that is wrong"
            );
        } else if let Some(camera) = key.strip_prefix("S_rect_").and_then(|digits| digits.parse::<u32>().ok()) {
            sizes.insert(camera, numbers()?);
        }
    }
    let there: Vec<_> = projections.keys().copied().collect();
    let cameras = match reading.cameras {
        Some(cameras) => named(&there, cameras)?,
        None => cameras(&there, reading.pair)?,
    };
    let projection = |camera: u32| -> Result<&Vec<f64>> {
        let numbers = projections.get(&camera).with_context(|| format!("it has no P{camera}"))?;
        ensure!(numbers.len() == 12, "its P{camera} has {} numbers, but must have 12: 3 x 4 by rows", numbers.len());
        Ok(numbers)
    };
    let unit = reading.unit(Unit::M);
    let camera = of_projections(projection(cameras[0])?, projection(cameras[1])?, unit.metres())?;
    let size = |camera: u32| -> Result<Option<[u32; 2]>> {
        match sizes.get(&camera).map(Vec::as_slice) {
            Some([width, height]) => Ok(Some([whole(&width.to_string())?, whole(&height.to_string())?])),
            _ => Ok(None),
        }
    };
    let [left_size, right_size] = [size(cameras[0])?, size(cameras[1])?];
    ensure!(
        left_size == right_size || left_size.is_none() || right_size.is_none(),
        "its cameras {} and {} differ in their size; use two of one size",
        cameras[0],
        cameras[1]
    );
    let size = left_size.or(right_size);
    Ok(Found { cameras: Cameras::Rectified(camera), size, unit: Some(unit) })
}

/// The cameras of `--calib-cams`.
fn named(there: &[u32], cameras: [u32; 2]) -> Result<[u32; 2]> {
    let all = there.iter().map(|camera| format!("P{camera}")).collect::<Vec<_>>().join(", ");
    for camera in cameras {
        ensure!(
            there.contains(&camera),
            "--calib-cams names the camera {camera}, but it has {all}; give two of these numbers"
        );
    }
    Ok(cameras)
}

/// The two cameras of those that are there.
fn cameras(there: &[u32], pair: Option<KittiPair>) -> Result<[u32; 2]> {
    let has = |camera: u32| there.contains(&camera);
    let [color, gray, driving] = [[2, 3], [0, 1], [101, 103]];
    let whole = |[left, right]: [u32; 2]| has(left) && has(right);
    let all = there.iter().map(|camera| format!("P{camera}")).collect::<Vec<_>>().join(", ");
    if whole(driving) && pair.is_some() {
        bail!("--calib-pair is for KITTI's cameras, but this is a calibration of DrivingStereo; drop it");
    }
    let wanted = match pair {
        Some(KittiPair::Color) => color,
        Some(KittiPair::Gray) => gray,
        None if has(2) || has(3) => color,
        None if has(0) || has(1) => gray,
        None => driving,
    };
    if whole(wanted) {
        return Ok(wanted);
    }
    let lacks = wanted.map(|camera| (!has(camera)).then(|| format!("no P{camera}"))).into_iter().flatten();
    let lacks = lacks.collect::<Vec<_>>().join(" and ");
    let remedy = match (wanted == color, wanted == gray) {
        (true, _) if whole(gray) => "give --calib-pair gray if P0 and P1 took the pair",
        (_, true) if whole(color) => "drop --calib-pair if P2 and P3 took the pair",
        _ => "a pair is P2 and P3, P0 and P1, or P_rect_101 and P_rect_103; use a file with both of its cameras",
    };
    bail!("it has {all}, but {lacks}; {remedy}")
}
