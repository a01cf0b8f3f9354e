//! Choices: what can be typed for a type of the library, and what `--help` says of it.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use gpu_stereo::Colors;
use gpu_stereo::backend::Backend;
use gpu_stereo::files::calibration::{KittiPair, LensModel, Unit};
use gpu_stereo::files::datasets::DataSet;
use gpu_stereo::files::encoders::{Format, Look, PointFormat, SampleFormat};
use gpu_stereo::files::images::{Arrangement, Split};

/// What can be typed, the usual name first, what it means, and what `--help` says of it.
type Choice<T> = (&'static [&'static str], T, &'static str);

fn choice<T: Copy + Send + Sync + 'static>(all: &'static [Choice<T>]) -> impl TypedValueParser<Value = T> {
    let shown = |(names, _, help): &Choice<T>| {
        let value = PossibleValue::new(names[0]).aliases(&names[1..]);
        if help.is_empty() { value } else { value.help(*help) }
    };
    PossibleValuesParser::new(all.iter().map(shown)).try_map(move |typed| {
        let found = all.iter().find(|(names, ..)| names.contains(&typed.as_str()));
        found.map(|(_, value, _)| *value).ok_or("it is none of the values that are known")
    })
}

/// What [`FORMATS`] has.
pub fn format() -> impl TypedValueParser<Value = Format> {
    choice(&FORMATS)
}

/// What [`COLORS`] has.
pub fn colors() -> impl TypedValueParser<Value = Colors> {
    choice(&COLORS)
}

/// What [`LAYOUTS`] has.
pub fn layout() -> impl TypedValueParser<Value = DataSet> {
    choice(&LAYOUTS)
}

/// What [`UNITS`] has.
pub fn unit() -> impl TypedValueParser<Value = Unit> {
    choice(&UNITS)
}

/// What [`PAIRS`] has.
pub fn pair() -> impl TypedValueParser<Value = KittiPair> {
    choice(&PAIRS)
}

/// What [`LENSES`] has.
pub fn lens() -> impl TypedValueParser<Value = LensModel> {
    choice(&LENSES)
}

/// What [`BACKENDS`] has.
pub fn backend() -> impl TypedValueParser<Value = Backend> {
    choice(&BACKENDS)
}

/// What [`SPLITS`] has.
pub fn split() -> impl TypedValueParser<Value = Split> {
    choice(&SPLITS)
}

/// `--backend`.
const BACKENDS: [Choice<Backend>; 4] = [
    (&["auto"], Backend::Auto, "The best one available"),
    (&["gpu"], Backend::Gpu, "Any adapter, a CPU adapter such as lavapipe included"),
    (&["cpu"], Backend::Cpu, "The native schedule"),
    (&["reference"], Backend::Reference, "The reference in plain Rust"),
];

/// `--split`.
const SPLITS: [Choice<Split>; 7] = [
    (&["auto"], Split::Auto, "As the file says: the index of MPO, the marker of JPS; the default"),
    (&["sbs"], Split::both(Arrangement::SideBySide, false), "Side by side, the left view in the left half"),
    (&["sbs-swapped"], Split::both(Arrangement::SideBySide, true), "Side by side, the right view in the left half"),
    (&["tb"], Split::both(Arrangement::TopBottom, false), "The left view in the upper half"),
    (&["tb-swapped"], Split::both(Arrangement::TopBottom, true), "The right view in the upper half"),
    (&["interlaced"], Split::both(Arrangement::Interlaced, false), "Rows in turn, the first one of the left view"),
    (
        &["interlaced-swapped"],
        Split::both(Arrangement::Interlaced, true),
        "Rows in turn, the first one of the right view",
    ),
];

/// `--colors`.
const COLORS: [Choice<Colors>; 7] = [
    (&["turbo"], Colors::Turbo, "Blue, green, yellow, red"),
    (&["inferno"], Colors::Inferno, "Purple, red, yellow, white"),
    (&["magma"], Colors::Magma, "Purple, pink, white"),
    (&["plasma"], Colors::Plasma, "Purple, orange, yellow"),
    (&["viridis"], Colors::Viridis, "Blue, green, yellow"),
    (&["cividis"], Colors::Cividis, "Blue, gray, yellow: alike to all eyes"),
    (&["gray", "grey"], Colors::Gray, "Dark gray to white"),
];

/// Replaced by what `--colors` and `--scale-bar` say.
const LOOK: Look = Look { colors: Colors::Turbo, scale_bar: false };

/// `--format`.
const FORMATS: [Choice<Format>; 19] = [
    (&["png"], Format::Disparity(SampleFormat::Png), ""),
    (&["pfm"], Format::Disparity(SampleFormat::Pfm), ""),
    (&["npy"], Format::Disparity(SampleFormat::Npy), ""),
    (&["tif", "tiff"], Format::Disparity(SampleFormat::Tiff), ""),
    (&["color"], Format::Color(LOOK), ""),
    (&["mask"], Format::Mask, ""),
    (&["confidence"], Format::Confidence, ""),
    (&["rectified-left"], Format::RectifiedLeft, ""),
    (&["rectified-right"], Format::RectifiedRight, ""),
    (&["right", "right-png"], Format::Right(SampleFormat::Png), ""),
    (&["right-pfm"], Format::Right(SampleFormat::Pfm), ""),
    (&["right-npy"], Format::Right(SampleFormat::Npy), ""),
    (&["right-tif", "right-tiff"], Format::Right(SampleFormat::Tiff), ""),
    (&["depth", "depth-png"], Format::Depth(SampleFormat::Png), ""),
    (&["depth-pfm"], Format::Depth(SampleFormat::Pfm), ""),
    (&["depth-npy"], Format::Depth(SampleFormat::Npy), ""),
    (&["depth-tif", "depth-tiff"], Format::Depth(SampleFormat::Tiff), ""),
    (&["points", "points-ply", "ply"], Format::Points(PointFormat::Ply), ""),
    (&["points-pcd", "pcd"], Format::Points(PointFormat::Pcd), ""),
];

/// `--layout`.
const LAYOUTS: [Choice<DataSet>; 6] = [
    (&["kitti2012"], DataSet::Kitti2012, "training/{colored_0,colored_1,disp_occ,disp_noc}, else image_0, image_1"),
    (&["kitti2015"], DataSet::Kitti2015, "training/{image_2,image_3,disp_occ_0,disp_noc_0}"),
    (
        &["middlebury"],
        DataSet::Middlebury,
        "trainingQ/NAME/{im0.png,im1.png,calib.txt,disp0GT.pfm,mask0nocc.png}, and H, F, test",
    ),
    (&["eth3d"], DataSet::Eth3d, "two_view_training/NAME with the same files"),
    (&["vkitti2"], DataSet::Vkitti2, "SceneNN/VARIANT/frames/{rgb,depth}/{Camera_0,Camera_1}"),
    (&["manifest"], DataSet::Manifest, "A JSON list of scenes, MANIFEST.json in the folder or the file itself"),
];

/// `--calib-unit`.
const UNITS: [Choice<Unit>; 3] =
    [(&["m"], Unit::M, "Metres"), (&["cm"], Unit::Cm, "Centimetres"), (&["mm"], Unit::Mm, "Millimetres")];

/// `--calib-pair`.
const PAIRS: [Choice<KittiPair>; 2] =
    [(&["color"], KittiPair::Color, "P2 and P3"), (&["gray"], KittiPair::Gray, "P0 and P1")];

/// `--lens`.
const LENSES: [Choice<LensModel>; 3] = [
    (&["auto"], LensModel::Auto, "The one that the file names, or that its numbers can only be of"),
    (&["pinhole"], LensModel::Pinhole, "calibrateCamera: k1, k2, p1, p2, k3 .."),
    (&["fisheye"], LensModel::Fisheye, "cv::fisheye, equidistant: k1, k2, k3, k4"),
];
