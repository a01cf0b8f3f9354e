//! Calibration files become the cameras of a pair. The content tells the kind: Middlebury's calib.txt, KITTI's calib files,
//! OpenCV's FileStorage in YAML or XML, and pairs of ROS camera_info files.

use crate::stereo_rectify::stereo_rectify;
use anyhow::{Context as _, Result, anyhow, bail, ensure};
use gpu_stereo::{Camera, Lens};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use yaml_rust2::Event;
use yaml_rust2::parser::Parser;

/// The largest file that is taken, and the deepest nesting of what is in it.
const MAX_BYTES: u64 = 1 << 20;
const MAX_DEPTH: usize = 16;

/// The unit of lengths in a calibration, of those that have no unit of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Unit {
    /// Metres
    M,
    /// Centimetres
    Cm,
    /// Millimetres
    Mm,
}

impl Unit {
    fn metres(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Cm => 1e-2,
            Self::Mm => 1e-3,
        }
    }
}

/// The cameras of a KITTI calibration that took the pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Pair {
    /// P2 and P3
    Color,
    /// P0 and P1
    Gray,
}

/// What is asked of a calibration beside its file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reading {
    /// The unit of its lengths; millimetres in Middlebury's files, else metres, if it is not given.
    pub unit: Option<Unit>,
    /// The cameras of a KITTI file; the colour pair, if it is there and nothing is given.
    pub pair: Option<Pair>,
    /// Whether the lenses are wanted.
    pub lenses: bool,
}

/// What a calibration says.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// The cameras of the rectified pair.
    pub camera: Camera,
    /// Columns and rows of the images that were calibrated, if the file tells.
    pub size: Option<[u32; 2]>,
    /// The lenses of a pair that is to be rectified.
    pub lenses: Option<[Lens; 2]>,
}

impl Calibration {
    /// A calibration of one file, or of a file for each camera.
    pub fn read(path: &Path, right: Option<&Path>, reading: Reading) -> Result<Self> {
        let (source, right_source) = (Source::read(path)?, right.map(Source::read).transpose()?);
        let told = || right.map_or(format!("{path:?}"), |right| format!("{path:?} with {right:?}"));
        Self::of(source, right_source, reading).with_context(told)
    }

    /// What one file says, or a file for each camera.
    pub fn of(mut source: Source, mut right: Option<Source>, reading: Reading) -> Result<Self> {
        // OpenCV's sample has a file of the lenses, and one of what lies between the cameras.
        if let (Source::Tree(tree), Some(Source::Tree(more))) = (&mut source, &right)
            && !is_camera_info(tree)
            && !is_camera_info(more)
        {
            tree.extend(more.clone());
            right = None;
        }
        let mut calibration = match (&source, &right) {
            (Source::Tree(tree), None) if reading.lenses && is_unrectified(tree) => unrectified(tree, reading)?,
            (_, None) => source.calibration(reading)?,
            (_, Some(right)) => pair_of_files(&source, right, reading)?,
        };
        calibration.camera.validate()?;
        if reading.lenses && calibration.lenses.is_none() {
            calibration.lenses = Some(lenses(&source, right.as_ref())?);
        }
        Ok(calibration)
    }

    /// Whether it is of images of this size.
    pub fn ensure_size(&self, width: u32, height: u32) -> Result<()> {
        match self.size {
            Some([w, h]) if [w, h] != [width, height] => bail!(
                "the images are {width}x{height}, but the calibration is of {w}x{h}; take the calibration of these images, or \
                 scale its numbers and give --focal, --baseline, --doffs, --cx and --cy"
            ),
            _ => Ok(()),
        }
    }
}

/// A file, read and told apart by its content.
pub enum Source {
    Middlebury(BTreeMap<String, String>),
    Kitti(BTreeMap<String, Vec<f64>>),
    /// YAML or XML: the scalars under each path of names.
    Tree(Tree),
}

pub type Tree = BTreeMap<String, Vec<String>>;

impl Source {
    fn read(path: &Path) -> Result<Self> {
        let kind = fs::metadata(path).with_context(|| format!("{path:?} cannot be read; give a calibration file"))?;
        ensure!(kind.is_file(), "{path:?} is not a regular file; give a calibration file");
        ensure!(
            kind.len() <= MAX_BYTES,
            "{path:?} has {} bytes, but a calibration has at most {MAX_BYTES}; give a calibration file",
            kind.len()
        );
        let bytes = fs::read(path).with_context(|| format!("{path:?} cannot be read; check its permissions"))?;
        Self::parse(&bytes).with_context(|| format!("{path:?}"))
    }

    /// What the bytes of a file say.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        let text = std::str::from_utf8(bytes).map_err(|_| {
            anyhow!("it is no text; give a calibration of Middlebury, KITTI, OpenCV (YAML, XML) or ROS (YAML)")
        })?;
        let text = text.trim_start_matches('\u{feff}');
        ensure!(!text.trim().is_empty(), "it is empty; give a calibration file");
        if text.trim_start().starts_with('<') {
            return xml(text).map(Self::Tree);
        }
        if text.lines().any(|line| line.trim_start().starts_with("cam0")) {
            let pairs = text.lines().filter_map(|line| line.split_once('='));
            return Ok(Self::Middlebury(pairs.map(|(key, value)| (key.trim().into(), value.trim().into())).collect()));
        }
        let projection = |line: &str| {
            line.split_once(':').is_some_and(|(key, values)| {
                key.trim().starts_with('P') && values.split_whitespace().filter(|word| number(word).is_ok()).count() > 1
            })
        };
        if text.lines().any(projection) {
            return kitti_lines(text).map(Self::Kitti);
        }
        if let Some(values) = kitti_unnamed(text) {
            return Ok(Self::Kitti(values));
        }
        yaml(text).map(Self::Tree)
    }

    fn calibration(&self, reading: Reading) -> Result<Calibration> {
        match self {
            Self::Middlebury(values) => middlebury(values, reading),
            Self::Kitti(values) => kitti(values, reading),
            Self::Tree(tree) => opencv(tree, reading),
        }
    }
}

fn number(text: &str) -> Result<f64> {
    let value: f64 = text.trim().parse().map_err(|_| anyhow!("{text:?} is no number; correct the file"))?;
    ensure!(value.is_finite(), "{text:?} is not finite; correct the file");
    Ok(value)
}

fn whole(text: &str) -> Result<u32> {
    match number(text)? {
        value if value.fract() == 0.0 && (1.0..=1e6).contains(&value) => Ok(value as u32),
        _ => bail!("{text:?} is no size; it must be a whole number from 1 on"),
    }
}

/// The cameras of two projection matrices, 3 x 4 by rows.
fn of_projections(left: &[f64], right: &[f64], unit: f64) -> Result<Camera> {
    let same = |a: f64, b: f64| (a - b).abs() <= 1e-5 * a.abs().max(b.abs());
    let (focal, right_focal) = (left[0], right[0]);
    ensure!(focal > 0.0, "the focal length is {focal} px, but must be more than 0; correct the projection matrix");
    ensure!(
        same(focal, right_focal),
        "the focal lengths are {focal} and {right_focal} px, but a rectified pair has one; take its projection matrices"
    );
    ensure!(
        (left[5] - focal).abs() <= 1e-3 * focal,
        "the focal length is {focal} px along rows and {} px along columns, but pixels must be square; scale the images",
        left[5]
    );
    let [across, down] = [3, 7].map(|i| (left[i] - right[i]) / focal * unit);
    ensure!(
        across.abs() > 0.0 && down.abs() < 0.1 * across.abs(),
        "the cameras lie {across} m apart along rows and {down} m along columns, but must lie side by side; rectify the pair \
         horizontally"
    );
    ensure!(
        across > 0.0,
        "the baseline is {across} m: the right camera lies to the left of the left one; exchange the cameras or the sign"
    );
    Ok(Camera { focal, baseline: across, doffs: right[2] - left[2], cx: left[2], cy: left[6] })
}

/// `cam0=[f 0 cx; 0 f cy; 0 0 1]`, `cam1`, `doffs`, `baseline`, `width`, `height`: vision.middlebury.edu/stereo/submit3.
fn middlebury(values: &BTreeMap<String, String>, reading: Reading) -> Result<Calibration> {
    let text = |key: &str| values.get(key).with_context(|| format!("it has no {key}; add a line {key}=.."));
    let matrix = |key: &str| -> Result<Vec<f64>> {
        let given = text(key)?;
        let words = given.trim_matches(['[', ']']).split([' ', ';', ',', '\t']).filter(|word| !word.is_empty());
        let numbers =
            words.map(number).collect::<Result<Vec<_>>>().with_context(|| format!("its {key} is {given:?}"))?;
        ensure!(
            numbers.len() == 9,
            "its {key} has {} numbers, but must have 9: [f 0 cx; 0 f cy; 0 0 1]",
            numbers.len()
        );
        Ok(numbers)
    };
    let (left, right) = (matrix("cam0")?, matrix("cam1")?);
    let unit = reading.unit.unwrap_or(Unit::Mm).metres();
    let baseline = text("baseline").and_then(|text| number(text)).context("its baseline")?;
    let projection =
        |k: &[f64], shift: f64| vec![k[0], k[1], k[2], shift, k[3], k[4], k[5], 0.0, k[6], k[7], k[8], 0.0];
    let camera = of_projections(&projection(&left, 0.0), &projection(&right, -baseline * right[0]), unit)?;
    if let Some(doffs) = values.get("doffs") {
        let doffs = number(doffs).context("its doffs")?;
        ensure!(
            (doffs - camera.doffs).abs() < 0.02,
            "its doffs is {doffs}, but cam1 less cam0 says {}; correct the one or the other",
            camera.doffs
        );
    }
    let size = match (values.get("width"), values.get("height")) {
        (Some(width), Some(height)) => Some([whole(width)?, whole(height)?]),
        _ => None,
    };
    Ok(Calibration { camera, size, lenses: None })
}

/// Nothing but lines of 12 numbers: the matrices from P0 on, without their names.
fn kitti_unnamed(text: &str) -> Option<BTreeMap<String, Vec<f64>>> {
    let matrix = |line: &str| {
        let numbers: Vec<f64> = line.split_whitespace().map(|word| number(word).ok()).collect::<Option<_>>()?;
        (numbers.len() == 12).then_some(numbers)
    };
    let lines: Vec<_> = text.lines().filter(|line| !line.trim().is_empty()).map(matrix).collect::<Option<_>>()?;
    let named = lines.into_iter().enumerate().map(|(camera, numbers)| (format!("P{camera}"), numbers));
    Some(named.collect())
}

fn kitti_lines(text: &str) -> Result<BTreeMap<String, Vec<f64>>> {
    let mut found = BTreeMap::new();
    for line in text.lines() {
        let Some((key, values)) = line.split_once(':') else { continue };
        let key = key.trim();
        let key = key.strip_prefix("P_rect_0").map_or(key.to_string(), |camera| format!("P{camera}"));
        if key.starts_with('P') || key.starts_with("S_rect") {
            let numbers = values.split_whitespace().map(number).collect::<Result<Vec<_>>>();
            found.insert(key.clone(), numbers.with_context(|| format!("its {key}"))?);
        }
    }
    Ok(found)
}

/// `P0` to `P3`, or `P_rect_00` to `P_rect_03`: 3 x 4 projection matrices of the rectified cameras.
fn kitti(values: &BTreeMap<String, Vec<f64>>, reading: Reading) -> Result<Calibration> {
    let pair = match reading.pair {
        Some(pair) => pair,
        None if values.contains_key("P2") => Pair::Color,
        None => Pair::Gray,
    };
    let cameras = match pair {
        Pair::Color => [2, 3],
        Pair::Gray => [0, 1],
    };
    let projection = |camera: u32| -> Result<&Vec<f64>> {
        let key = format!("P{camera}");
        let numbers = values.get(&key).with_context(|| format!("it has no {key}; take the other --calib-pair"))?;
        ensure!(numbers.len() == 12, "its {key} has {} numbers, but must have 12: 3 x 4 by rows", numbers.len());
        Ok(numbers)
    };
    let unit = reading.unit.unwrap_or(Unit::M).metres();
    let camera = of_projections(projection(cameras[0])?, projection(cameras[1])?, unit)?;
    let size = match values.get(&format!("S_rect_0{}", cameras[0])).map(Vec::as_slice) {
        Some([width, height]) => Some([whole(&width.to_string())?, whole(&height.to_string())?]),
        _ => None,
    };
    Ok(Calibration { camera, size, lenses: None })
}

/// What a camera's numbers are called: in OpenCV's files the left one's and the right one's, and in a file of ROS.
struct Names([&'static [&'static str]; 2], &'static [&'static str]);

const MATRIX: Names = Names(
    [&["M1", "K1", "cameraMatrix1", "camera_matrix_1"], &["M2", "K2", "cameraMatrix2", "camera_matrix_2"]],
    &["camera_matrix", "K", "k"],
);
const DISTORTION: Names = Names(
    [
        &["D1", "distCoeffs1", "dist_coeffs_1", "distortion_coefficients_1"],
        &["D2", "distCoeffs2", "dist_coeffs_2", "distortion_coefficients_2"],
    ],
    &["distortion_coefficients", "D", "d"],
);
const ROTATION: Names =
    Names([&["R1", "rectification_matrix_1"], &["R2", "rectification_matrix_2"]], &["rectification_matrix", "R", "r"]);
const PROJECTION: Names = Names(
    [&["P1", "projectionMatrix1", "projection_matrix_1"], &["P2", "projectionMatrix2", "projection_matrix_2"]],
    &["projection_matrix", "P", "p"],
);

/// Whether a file tells how the cameras lie, but not how the rectified ones do.
fn is_unrectified(tree: &Tree) -> bool {
    tree.contains_key("R.data") && tree.contains_key("T.data") && !tree.contains_key("R1.data")
}

/// `M1`, `D1`, `M2`, `D2`, and `R` and `T` of OpenCV's stereoCalibrate.
fn unrectified(tree: &Tree, reading: Reading) -> Result<Calibration> {
    let size = size_of(tree)?.context(
        "it has R and T, but not the size of the images, which stereoRectify needs; add image_width and image_height",
    )?;
    let wanted = |name: &'static str, shapes: &[(usize, usize)]| {
        matrix(tree, &[name], shapes)?.with_context(|| format!("it has no {name}"))
    };
    let (r, t) = (wanted("R", &[(3, 3)])?, wanted("T", &[(3, 1), (1, 3)])?);
    let r: [f64; 9] = std::array::from_fn(|i| r[i]);
    ensure_rotation(&r, "R")?;
    let side = |side: usize| {
        Ok::<_, anyhow::Error>((camera_matrix(tree, MATRIX.0[side])?, distortion(tree, DISTORTION.0[side])?))
    };
    let (lenses, [left, right]) = stereo_rectify([side(0)?, side(1)?], size, &r, &[t[0], t[1], t[2]])?;
    let unit = reading.unit.unwrap_or(Unit::M).metres();
    Ok(Calibration { camera: of_projections(&left, &right, unit)?, size: Some(size), lenses: Some(lenses) })
}

/// The lens and the rectified camera of both sides.
fn lenses(left: &Source, right: Option<&Source>) -> Result<[Lens; 2]> {
    let (Source::Tree(left), None | Some(Source::Tree(_))) = (left, right) else {
        bail!("it has no lenses, since its pairs are rectified; --calib takes it without --rectify");
    };
    let of = |side: usize| {
        let tree = match right {
            Some(Source::Tree(right)) if side == 1 => right,
            _ => left,
        };
        lens(tree, |names| if right.is_some() { names.1 } else { names.0[side] })
    };
    Ok([of(0)?, of(1)?])
}

const NEEDED: &str = "--rectify needs M1, D1, M2, D2 and either R1, P1, R2 and P2 or R and T";

fn lens(tree: &Tree, names: impl Fn(&Names) -> &'static [&'static str]) -> Result<Lens> {
    if let Some(model) = tree.get("distortion_model").and_then(|model| model.first()) {
        ensure!(
            ["plumb_bob", "rational_polynomial"].contains(&model.as_str()),
            "its distortion_model is {model}, but plumb_bob and rational_polynomial are known; calibrate with one of these"
        );
    }
    let matrix = camera_matrix(tree, names(&MATRIX))?;
    let distortion = distortion(tree, names(&DISTORTION))?;
    let rotation = nine(tree, names(&ROTATION))?;
    ensure_rotation(&rotation, names(&ROTATION)[0])?;
    let projection = needed(tree, names(&PROJECTION), &[(3, 4)])?;
    Ok(Lens { matrix, distortion, rotation, projection: std::array::from_fn(|i| projection[i / 3 * 4 + i % 3]) })
}

fn needed(tree: &Tree, names: &[&str], shapes: &[(usize, usize)]) -> Result<Vec<f64>> {
    matrix(tree, names, shapes)?.with_context(|| format!("it has no {}; {NEEDED}", names[0]))
}

fn nine(tree: &Tree, names: &[&str]) -> Result<[f64; 9]> {
    let numbers = needed(tree, names, &[(3, 3)])?;
    Ok(std::array::from_fn(|i| numbers[i]))
}

fn camera_matrix(tree: &Tree, names: &[&str]) -> Result<[f64; 9]> {
    let numbers = nine(tree, names)?;
    for focal in [numbers[0], numbers[4]] {
        ensure!(focal > 0.0, "its {} has a focal length of {focal}, but it must be more than 0; correct it", names[0]);
    }
    Ok(numbers)
}

fn distortion(tree: &Tree, names: &[&str]) -> Result<[f64; 8]> {
    let counts = [4, 5, 8, 12, 14].map(|count| [(1, count), (count, 1)]);
    let numbers = needed(tree, names, counts.as_flattened())?;
    ensure!(
        numbers.iter().skip(8).all(|&number| number == 0.0),
        "its {} has a thin prism or a tilt, but only k1 to k6, p1 and p2 are known; calibrate without",
        names[0]
    );
    Ok(std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(0.0)))
}

fn ensure_rotation(rotation: &[f64; 9], name: &str) -> Result<()> {
    for (i, j) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
        let sum: f64 = (0..3).map(|k| rotation[3 * i + k] * rotation[3 * j + k]).sum();
        let is = if i == j { 1.0 } else { 0.0 };
        ensure!((sum - is).abs() < 1e-3, "its {name} is no rotation; save it again");
    }
    Ok(())
}

/// `P1` and `P2`, or `Q`, of OpenCV's stereoRectify.
fn opencv(tree: &Tree, reading: Reading) -> Result<Calibration> {
    let unit = reading.unit.unwrap_or(Unit::M).metres();
    let size = size_of(tree)?;
    let left = matrix(tree, PROJECTION.0[0], &[(3, 4)])?;
    let right = matrix(tree, PROJECTION.0[1], &[(3, 4)])?;
    let camera = match (left, right, matrix(tree, &["Q", "disparity_to_depth"], &[(4, 4)])?) {
        (Some(left), Some(right), _) => of_projections(&left, &right, unit)?,
        (_, _, Some(q)) => of_q(&q, unit)?,
        (None, None, None) if is_camera_info(tree) => {
            bail!("it is the calibration of one camera; give that of the right one by --calib-right")
        }
        (left, ..) => bail!(
            "it has no {}; a calibration of OpenCV must have P1 and P2, or Q, as stereoRectify gives them",
            if left.is_none() { "P1 and no Q" } else { "P2 and no Q" }
        ),
    };
    Ok(Calibration { camera, size, lenses: None })
}

/// Q = [1 0 0 -cx; 0 1 0 -cy; 0 0 0 f; 0 0 1 / B doffs / B] of OpenCV's stereoRectify.
fn of_q(q: &[f64], unit: f64) -> Result<Camera> {
    ensure!(
        q[14] != 0.0 && q[13] == 0.0,
        "its Q has {} and {} in row 4, but must have 0 and 1 / baseline",
        q[13],
        q[14]
    );
    let (focal, baseline) = (q[11], 1.0 / q[14]);
    let (cx, cy, doffs) = (-q[3], -q[7], q[15] * baseline);
    let left = [focal, 0.0, cx, 0.0, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    let right = [focal, 0.0, cx + doffs, -focal * baseline, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    of_projections(&left, &right, unit)
}

fn is_camera_info(tree: &Tree) -> bool {
    PROJECTION.1.iter().any(|name| tree.contains_key(*name) || tree.contains_key(&format!("{name}.data")))
}

/// The size of an image in words.
fn pixels_of(size: Option<[u32; 2]>) -> String {
    size.map_or("no size".into(), |[width, height]| format!("{width}x{height} pixels"))
}

/// Two files of ROS: `projection_matrix`, or `P`.
fn pair_of_files(left: &Source, right: &Source, reading: Reading) -> Result<Calibration> {
    let (Source::Tree(left), Source::Tree(right)) = (left, right) else {
        bail!("--calib-right goes with the camera_info files of ROS (YAML), a file a camera; drop it");
    };
    let [left_size, right_size] = [size_of(left)?, size_of(right)?];
    ensure!(
        left_size == right_size,
        "the left camera has {} and the right one {}; take two calibrations of one size",
        pixels_of(left_size),
        pixels_of(right_size)
    );
    let projection = |tree| {
        matrix(tree, PROJECTION.1, &[(3, 4)])?
            .context("a file has no projection_matrix; give the camera_info of a rectified pair")
    };
    let unit = reading.unit.unwrap_or(Unit::M).metres();
    Ok(Calibration {
        camera: of_projections(&projection(left)?, &projection(right)?, unit)?,
        size: left_size,
        lenses: None,
    })
}

/// Columns and rows of the images, if they are there.
fn size_of(tree: &Tree) -> Result<Option<[u32; 2]>> {
    let one = |names: &[&str]| names.iter().find_map(|name| tree.get(*name)).and_then(|values| values.first());
    for name in ["image_size", "imageSize", "size"] {
        if let Some([width, height]) = tree.get(name).map(Vec::as_slice) {
            return Ok(Some([whole(width)?, whole(height)?]));
        }
    }
    match (one(&["image_width", "width", "imageWidth"]), one(&["image_height", "height", "imageHeight"])) {
        (Some(width), Some(height)) => Ok(Some([whole(width)?, whole(height)?])),
        _ => Ok(None),
    }
}

/// The numbers of a matrix by rows, if one of the names is there; it has one of the shapes.
fn matrix(tree: &Tree, names: &[&str], shapes: &[(usize, usize)]) -> Result<Option<Vec<f64>>> {
    for name in names {
        let at = |part: &str| tree.get(&format!("{name}.{part}"));
        let Some(data) = at("data").or_else(|| tree.get(*name)) else { continue };
        let numbers =
            data.iter().map(|text| number(text)).collect::<Result<Vec<_>>>().with_context(|| format!("its {name}"))?;
        let allowed =
            || shapes.iter().map(|(rows, columns)| format!("{rows} x {columns}")).collect::<Vec<_>>().join(" or ");
        let (rows, columns) = (at("rows").and_then(|v| v.first()), at("cols").and_then(|v| v.first()));
        let fits = |&(r, c): &(usize, usize)| {
            let is = |side: Option<&String>, of: usize| side.is_none_or(|text| text.trim().parse() == Ok(of));
            numbers.len() == r * c && is(rows, r) && is(columns, c)
        };
        if !shapes.iter().any(fits) {
            let told = match (rows, columns) {
                (Some(rows), Some(columns)) => format!("{rows} x {columns} with {} numbers", numbers.len()),
                _ => format!("{} numbers", numbers.len()),
            };
            bail!("its {name} is {told}, but must be {}; correct the file", allowed());
        }
        return Ok(Some(numbers));
    }
    Ok(None)
}

/// The scalars of a YAML file under the path of names that leads to them. OpenCV's header, `%YAML:1.0`, is not YAML's.
fn yaml(text: &str) -> Result<Tree> {
    let body: String = match text.trim_start().strip_prefix('%') {
        Some(rest) => rest.split_once('\n').map_or(String::new(), |(_, body)| body.into()),
        None => text.into(),
    };
    let mut tree = Tree::new();
    let mut parser = Parser::new_from_str(&body);
    // Of each mapping that is open the key that waits for its value, of each sequence nothing.
    let mut open: Vec<Option<Option<String>>> = Vec::new();
    loop {
        let (event, _) = parser.next_token().map_err(|error| {
            anyhow!(
                "it is no calibration of a known kind, nor YAML ({error}); give one of Middlebury, KITTI, OpenCV or ROS"
            )
        })?;
        match event {
            Event::StreamEnd => break,
            Event::Scalar(text, ..) => match open.last_mut() {
                Some(Some(key @ None)) => *key = Some(text),
                Some(_) => {
                    tree.entry(path_of(&open)).or_default().push(text);
                    filled(&mut open);
                }
                None => {}
            },
            Event::Alias(_) => bail!("it has an alias (*name); write its value in its place"),
            Event::MappingStart(..) | Event::SequenceStart(..) => {
                ensure!(open.len() < MAX_DEPTH, "it is nested more than {MAX_DEPTH} deep; that is no calibration");
                ensure!(
                    !matches!(open.last(), Some(Some(None))),
                    "it has a key that is no name; that is no calibration"
                );
                open.push(matches!(event, Event::MappingStart(..)).then_some(None));
            }
            Event::MappingEnd | Event::SequenceEnd => {
                open.pop();
                filled(&mut open);
            }
            _ => {}
        }
    }
    ensure!(!tree.is_empty(), "it holds no named value; give a calibration of Middlebury, KITTI, OpenCV or ROS");
    Ok(tree)
}

fn path_of(open: &[Option<Option<String>>]) -> String {
    open.iter().flatten().flatten().map(String::as_str).collect::<Vec<_>>().join(".")
}

/// The innermost mapping has the value of its key.
fn filled(open: &mut [Option<Option<String>>]) {
    if let Some(Some(key)) = open.last_mut() {
        *key = None;
    }
}

/// The same of an XML file of OpenCV: `<opencv_storage><P1 type_id="opencv-matrix"><rows>3</rows>..`.
fn xml(text: &str) -> Result<Tree> {
    // Many of them nested cost minutes: every element gets those of all around it.
    ensure!(!text.contains("xmlns"), "it has a namespace (xmlns), which OpenCV does not write; save it again");
    let options = roxmltree::ParsingOptions { nodes_limit: 100_000, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(text, options)
        .map_err(|error| anyhow!("it is damaged XML ({error}); save it again"))?;
    let mut tree = Tree::new();
    for node in document.root_element().descendants().filter(roxmltree::Node::is_text) {
        let names: Vec<_> = node.ancestors().filter(roxmltree::Node::is_element).take(MAX_DEPTH).collect();
        // The names from the root's children on; `_` is an item of a sequence.
        let path: Vec<_> =
            names.iter().rev().skip(1).map(|n| n.tag_name().name()).filter(|name| *name != "_").collect();
        let words = node.text().unwrap_or_default().split_whitespace().map(str::to_string);
        tree.entry(path.join(".")).or_default().extend(words);
    }
    tree.retain(|_, words| !words.is_empty());
    ensure!(!tree.is_empty(), "it holds no named value; give a calibration of Middlebury, KITTI, OpenCV or ROS");
    Ok(tree)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const SAMPLES: [&str; 5] = [
        "cam0=[100 0 33; 0 100 15.5; 0 0 1]\ncam1=[100 0 34.5; 0 100 15.5; 0 0 1]\ndoffs=1.5\nbaseline=500\nwidth=67\n",
        "P2: 1.0e+02 0 33 4.5 0 1e2 15.5 0.2 0 0 1 0.003\nP3: 1.0e+02 0 34.5 -45.5 0 1e2 15.5 0.3 0 0 1 0.003\n",
        "%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1., 0., 2., 0., 1., 3., 0., 0., 1. ]\n",
        "<?xml version=\"1.0\"?>\n<opencv_storage><Q type_id=\"opencv-matrix\"><rows>4</rows><cols>4</cols><dt>d</dt>\n\
         <data>1. 0. 0. -33. 0. 1. 0. -15. 0. 0. 0. 100. 0. 0. 2. 3.</data></Q></opencv_storage>\n",
        "image_width: 67\nimage_height: 31\nprojection_matrix:\n  rows: 3\n  cols: 4\n  data: [100.0, 0.0, 33, 0, 0.0, 100.0, \
         15.5, 0.0, 0.0, 0.0, 1.0, 0.0]\n",
    ];

    /// KITTI's matrices as some pass them on, without their names.
    #[test]
    fn lines_of_twelve_numbers_are_p0_and_p1() {
        let text = "1e2 0 33 0 0 1e2 15.5 0 0 0 1 0\n1e2 0 33 -45 0 1e2 15.5 0 0 0 1 0";
        let camera = Source::parse(text.as_bytes()).unwrap().calibration(Reading::default()).unwrap().camera;
        assert_eq!((camera.focal, camera.baseline, camera.cx, camera.cy), (100.0, 0.45, 33.0, 15.5));
        assert!(Source::parse(b"1e2 0 33 0 0 1e2 15.5 0 0 0 1\n").is_err());
    }

    #[test]
    fn nested_namespaces_are_refused_at_once() {
        let nested: String = (0..30_000).map(|i| format!("<a xmlns:b{i}=\"c{i}\">")).collect();
        let error = Source::parse(nested.as_bytes()).err().unwrap();
        assert!(error.to_string().contains("xmlns"), "{error}");
    }

    /// Whatever bytes are changed, lost, doubled or taken from another kind: an answer or an error, and an answer is sound.
    #[test]
    fn spoilt_calibrations_never_panic() {
        let (mut good, mut bad) = (0, 0);
        for seed in 0..20_000 {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let mut bytes = SAMPLES[seed as usize % 5].as_bytes().to_vec();
            for _ in 0..random.random_range(0..4) {
                let (at, to) = (random.random_range(0..bytes.len()), random.random_range(0..bytes.len()));
                let (from, to) = (at.min(to), at.max(to));
                match random.random_range(0..5) {
                    0 => bytes[at] = b"0123456789.-+eE[]{}<>:;,=%!&*#'\" \n\tPQnaif\0\xff"[random.random_range(0..43)],
                    1 => bytes.truncate(at.max(1)),
                    2 => drop(bytes.drain(from..to)),
                    3 => bytes.extend_from_within(from..to),
                    _ => bytes.extend_from_slice(SAMPLES[random.random_range(0..5)].as_bytes()),
                }
                if bytes.is_empty() {
                    bytes.push(b' ');
                }
            }
            let Ok(source) = Source::parse(&bytes) else {
                bad += 1;
                continue;
            };
            let _ = lenses(&source, Some(&source));
            let _ = pair_of_files(&source, &source, Reading::default());
            match source.calibration(Reading::default()) {
                Ok(Calibration { camera, .. }) => {
                    assert!(camera.focal > 0.0 && camera.baseline > 0.0, "{camera:?}, seed {seed}");
                    good += 1;
                }
                Err(error) => {
                    assert!(!format!("{error:#}").contains('\n'), "{error:#}, seed {seed}");
                    bad += 1;
                }
            }
        }
        assert!(good > 2000 && bad > 2000, "{good} good, {bad} bad");
    }
}
