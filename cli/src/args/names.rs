//! Names that other programs give to our options and values, and the nearest name to a typing error. No tip is better than a
//! misleading one.

use gpu_stereo::{Params, Preset};

/// Our options, and their names in OpenCV, libSGM, Middlebury's code and common use. Only letters and digits are compared.
pub const FOREIGN: &[(&str, &str)] = &[
    (
        "disp",
        "d n maxdisp maxdisparity maxdisparities numdisparities numdisparity numdisp numdisps ndisp ndisps ndisparities \
         disparities disparity dispsize disprange disparityrange searchrange maxd range dmax",
    ),
    ("min-disp", "mindisparity mindisparities mind dmin firstdisparity"),
    ("block", "w blocksize windowsize winsize window sadwindowsize sadwindow kernel kernelsize blocksz wsize"),
    ("p1", "penalty1 smallpenalty"),
    ("p2", "penalty2 largepenalty"),
    ("uniqueness", "uniquenessratio uniqueratio uniq"),
    (
        "lr-check",
        "disp12maxdiff disp12 lr lrc lrmaxdiff lrcheckmaxdiff leftright leftrightcheck consistency consistencycheck",
    ),
    ("speckle-window", "specklewindowsize specklesize maxspecklesize speckle specklefilter"),
    ("speckle-range", "specklediff speckledifference specklemaxdiff"),
    ("prefilter-cap", "cap ftzero"),
    ("prefilter", "prefiltertype"),
    ("prefilter-window", "prefiltersize prefilterwindowsize"),
    ("texture", "texturethreshold"),
    ("paths", "numpaths pathtype npaths directions numdirections pathcount"),
    ("subpixel", "subpixelaccuracy subpix"),
    ("median", "medianfilter medianblur"),
    ("wls", "wlsfilter"),
    ("wls-lambda", "lambda"),
    ("wls-sigma", "sigma sigmacolor wlssigmacolor"),
    ("weighted-median", "wmf wm weightedmedianfilter"),
    ("method", "algorithm algo alg matcher mode"),
    ("cost", "costfunction costtype matchingcost similarity metric"),
    ("census", "censustype censuswindow censussize"),
    ("align-corners", "aligncorner"),
    ("weights", "loadmodel model modelpath checkpoint ckpt pretrained restoreckpt"),
    ("fill", "fillholes inpaint interpolate interpolation densify"),
    ("output", "outputdir outputfolder outputpath outputfile outdir outfile outpath out dst dest destination save o"),
    ("color", "colour colormap colourmap colorize visualize vis"),
    ("confidence", "conf confidencemap"),
    ("mask", "validmask"),
    ("adapter", "device deviceid gpuid gpuindex cuda"),
    ("list-adapters", "listdevices listgpus devices adapters"),
    ("calib", "calibration calibrationfile calibfile intrinsics intrinsic extrinsics camera cameras"),
    ("focal", "f focallength fx"),
    ("depth", "depthmap depthoutput outputdepth"),
    ("points", "pointcloud pointcloudfile cloud ply pcd xyz"),
    ("gt", "truth groundtruth gtdisp reference"),
    ("split", "sidebyside sbs stereomode stereolayout framepacking interlaced"),
    ("rectify", "rectification undistort remap"),
    ("timings", "time timing times profile"),
    ("repeat", "iterations iters iter runs"),
    ("threads", "jobs workers numthreads nthreads nproc"),
    ("resume", "continue skipexisting"),
    ("fps", "framerate rate"),
    ("quiet", "silent noprogress"),
    ("json", "jsonoutput asjson"),
    ("check", "verify validate selftest"),
];

/// Values of options, and their names elsewhere.
const FOREIGN_VALUES: &[(&str, &str, &str)] = &[
    ("method", "sgm", "sgbm stereosgbm semiglobal semiglobalmatching hh 3way libsgm"),
    ("method", "bm", "stereobm blockmatching block"),
    ("method", "psmnet", "psm stackhourglass network cnn"),
    ("cost", "bt", "birchfield birchfieldtomasi"),
    ("cost", "mi", "mutualinformation"),
    ("cost", "learned", "mccnn features"),
    ("cost", "census", "hamming ct"),
    ("subpixel", "parabola", "parabolic quadratic"),
    ("median", "off", "none 0 no"),
];

/// Words that are never confused with each other.
const OPPOSITES: &[(&str, &str)] =
    &[("min", "max"), ("left", "right"), ("on", "off"), ("p1", "p2"), ("cx", "cy"), ("in", "out"), ("gt", "lt")];

/// The letters and digits of a name, in lower case.
pub fn squeezed(name: &str) -> String {
    name.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect()
}

/// The edit distance of two words, with exchanged neighbours as one edit (Damerau-Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![(0..=b.len()).collect::<Vec<_>>()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = replaced.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            row.push(least);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

fn are_opposite(a: &str, b: &str) -> bool {
    let has = |text: &str, word: &str| text.split(['-', '_']).any(|part| part == word);
    OPPOSITES.iter().any(|(one, other)| (has(a, one) && has(b, other)) || (has(a, other) && has(b, one)))
}

/// The one known word that is near enough to be meant.
pub fn near<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    let most = (word.chars().count() / 3).min(2);
    let mut near: Vec<_> = known.map(|known| (distance(&word, known), known)).filter(|(far, _)| *far <= most).collect();
    near.retain(|(_, known)| !are_opposite(&word, known));
    near.sort_unstable();
    match near[..] {
        [(_, one)] => Some(one),
        [(first, one), (second, _), ..] if first < second => Some(one),
        _ => None,
    }
}

/// Our option for `name`: the same but for dashes and case, or its name elsewhere.
pub fn ours<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let name = squeezed(name);
    let foreign = FOREIGN.iter().find(|(_, names)| names.split(' ').any(|other| other == name)).map(|(ours, _)| *ours);
    let is_it = |known: &&&str| squeezed(known) == name;
    known.iter().find(is_it).or_else(|| known.iter().find(|known| foreign == Some(**known))).copied()
}

/// The option of [`Params`] that an unknown name most likely means.
pub fn setting(name: &str) -> Option<&'static str> {
    let known: Vec<_> = Params::OPTIONS.iter().map(|option| option.name).chain(["preset"]).collect();
    ours(name, &known).or_else(|| near(name, known.iter().copied()))
}

/// The preset, method or cost that an unknown word most likely means.
pub fn word(given: &str) -> Option<&'static str> {
    ["preset", "method", "cost"].into_iter().find_map(|option| value(option, given))
}

/// The value of an option that an unknown value most likely means.
pub fn value(option: &str, given: &str) -> Option<&'static str> {
    let words = match option {
        "preset" => Preset::NAMES,
        _ => Params::OPTIONS.iter().find(|known| known.name == option)?.values,
    };
    let squeezed_value = squeezed(given);
    let foreign = FOREIGN_VALUES
        .iter()
        .find(|(name, _, others)| *name == option && others.split(' ').any(|other| other == squeezed_value))
        .map(|(_, ours, _)| *ours);
    let known = || words.iter().map(|(word, _)| *word);
    known()
        .find(|word| squeezed(word) == squeezed_value)
        .or(foreign.filter(|ours| known().any(|word| word == *ours)))
        .or_else(|| near(given, known()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_other_programs_become_ours() {
        for (option, given, ours) in [
            ("method", "sgbm", Some("sgm")),
            ("method", "StereoBM", Some("bm")),
            ("cost", "SAD", Some("sad")),
            ("cost", "ad_census", Some("ad-census")),
            ("cost", "cenus", Some("census")),
            ("preset", "balancd", Some("balanced")),
            ("cost", "l2", None),
            ("method", "magic", None),
            ("disp", "x", None),
        ] {
            assert_eq!(value(option, given), ours, "{option} {given}");
        }
        assert_eq!((setting("blockSize"), setting("nonsense")), (Some("block"), None));
        assert_eq!((word("sgbm"), word("balancd"), word("nonsense")), (Some("sgm"), Some("balanced"), None));
    }

    #[test]
    fn what_is_not_near_is_not_meant() {
        assert_eq!(near("min-dips", ["min-disp"].into_iter()), Some("min-disp"));
        assert_eq!(near("max-disp", ["min-disp"].into_iter()), None);
        assert_eq!(near("left-view", ["right-view"].into_iter()), None);
    }
}
