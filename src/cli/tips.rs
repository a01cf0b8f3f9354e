//! Tips: errors of the command line, with what somebody most likely meant who made a slip or knows the names of another
//! program. A tip that may mislead is none.

use crate::args::Args;
use crate::{name, plain};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command, CommandFactory as _};
use std::ffi::OsString;
use std::path::Path;

/// Our options, and what others call them: OpenCV, libSGM, Middlebury's code and the usual words. Of all names only
/// letters and digits count.
const FOREIGN: &[(&str, &str)] = &[
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

/// What others call the values of options.
const FOREIGN_VALUES: &[(&str, &str, &str)] = &[
    ("method", "sgm", "sgbm stereosgbm semiglobal semiglobalmatching hh 3way libsgm"),
    ("method", "bm", "stereobm blockmatching block"),
    ("cost", "bt", "birchfield birchfieldtomasi"),
    ("cost", "mi", "mutualinformation"),
    ("cost", "census", "hamming ct"),
    ("subpixel", "parabola", "parabolic quadratic"),
    ("median", "off", "none 0 no"),
];

/// Words of which one is never meant by the other.
const OPPOSITES: &[(&str, &str)] =
    &[("min", "max"), ("left", "right"), ("on", "off"), ("p1", "p2"), ("cx", "cy"), ("in", "out"), ("gt", "lt")];

/// What counts of a name.
fn squeezed(name: &str) -> String {
    name.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect()
}

/// Letters to insert, to remove, to replace or to exchange with their neighbour to make one word the other.
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

/// The one known word that is so near that it must be meant.
fn near<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
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

/// Our name of what is called `name`: without its dashes or as others have it.
fn ours<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let name = squeezed(name);
    let foreign = FOREIGN.iter().find(|(_, names)| names.split(' ').any(|other| other == name)).map(|(ours, _)| *ours);
    let is_it = |known: &&&str| squeezed(known) == name;
    known.iter().find(is_it).or_else(|| known.iter().find(|known| foreign == Some(**known))).copied()
}

/// The option of [`gpu_stereo::Params`] that is meant by a name that is none.
pub fn setting(name: &str) -> Option<&'static str> {
    let known: Vec<_> = gpu_stereo::Params::OPTIONS.iter().map(|option| option.name).chain(["preset"]).collect();
    ours(name, &known).or_else(|| near(name, known.iter().copied()))
}

/// The preset, the method or the cost that is meant by a word that is none.
pub fn word(given: &str) -> Option<&'static str> {
    ["preset", "method", "cost"].into_iter().find_map(|option| value(option, given))
}

/// The value of an option that is meant by one that is not known.
pub fn value(option: &str, given: &str) -> Option<&'static str> {
    let words = match option {
        "preset" => gpu_stereo::Preset::NAMES,
        _ => gpu_stereo::Params::OPTIONS.iter().find(|known| known.name == option)?.values,
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

/// The error of a command line in one line: what was given, what is meant or allowed, and where more is.
pub fn error_line(mut error: clap::Error, args: &[OsString]) -> String {
    if error.kind() == ErrorKind::InvalidUtf8 {
        let wrong: Vec<_> =
            args.iter().filter(|arg| arg.to_str().is_none()).map(|arg| format!("{:?}", name(arg))).collect();
        return format!(
            "error: {} is not Unicode, which only names of files need not be; see gpu-stereo --help",
            wrong.join(", ")
        );
    }
    let verb = verb(args);
    let called = verb.as_ref().map_or("gpu-stereo".into(), |verb| format!("gpu-stereo {verb}"));
    if let Some(word) = error.get(ContextKind::InvalidSubcommand)
        && error.kind() == ErrorKind::ArgumentConflict
    {
        // Clap takes every word too many for a study.
        let meant = similar_verb(args)
            .unwrap_or_else(|| "give two images, with sweep or compare before them, or two maps after eval".into());
        return format!(
            "error: unexpected argument '{}' found; {meant}; see gpu-stereo --help",
            plain(&word.to_string())
        );
    }
    let unknown = match (error.kind(), error.get(ContextKind::InvalidArg)) {
        (ErrorKind::UnknownArgument, Some(ContextValue::String(unknown))) => Some(unknown.clone()),
        _ => None,
    };
    let mut tip = unknown.and_then(|unknown| tip(&unknown, verb.as_deref(), args));
    if let (Some(ContextValue::String(given)), Some(ContextValue::Strings(known))) =
        (error.get(ContextKind::InvalidValue), error.get(ContextKind::ValidValue))
    {
        tip = near(given, known.iter().map(String::as_str)).map(|near| format!("a similar value is {near}"));
    }
    // Clap quotes what was typed as it is.
    let shown: Vec<_> = error.context().filter_map(|(kind, value)| Some((kind, shown(value)?))).collect();
    for (kind, value) in shown {
        error.insert(kind, value);
    }
    let text = error.render().to_string();
    let is_advice = |line: &str| line.starts_with("Usage:") || line.starts_with("For more information");
    // Clap's own tips are of any word that begins alike.
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("tip:"));
    let told: Vec<_> = lines.take_while(|line| !is_advice(line)).collect();
    let tip = tip.map(|tip| format!("; {tip}")).unwrap_or_default();
    format!("{}{tip}; see {called} --help", told.join(" "))
}

/// What was typed without what a terminal would obey.
fn shown(value: &ContextValue) -> Option<ContextValue> {
    match value {
        ContextValue::String(text) => Some(ContextValue::String(plain(text))),
        ContextValue::Strings(texts) => Some(ContextValue::Strings(texts.iter().map(|text| plain(text)).collect())),
        _ => None,
    }
}

/// The verb of a command line, without the program's name.
fn verb(args: &[OsString]) -> Option<String> {
    let first = args.first()?.to_str()?;
    Args::command().get_subcommands().map(Command::get_name).find(|name| *name == first).map(Into::into)
}

/// The verb that the first word is most likely meant to be.
fn similar_verb(args: &[OsString]) -> Option<String> {
    let root = Args::command();
    let first = args.first()?.to_str()?;
    near(first, root.get_subcommands().map(Command::get_name)).map(|verb| format!("a similar verb is {verb}"))
}

/// The long options of a command, aliases among them.
fn longs(command: &Command) -> Vec<(&str, &Arg)> {
    let of = |arg| {
        Arg::get_long(arg).into_iter().chain(arg.get_all_aliases().unwrap_or_default()).map(move |long| (long, arg))
    };
    command.get_arguments().flat_map(of).collect()
}

/// An option with its value.
fn with_value((long, arg): &(&str, &Arg)) -> String {
    let values = arg.get_value_names().filter(|_| arg.get_action().takes_values()).unwrap_or_default();
    let values: String = values.iter().map(|value| format!(" <{value}>")).collect();
    format!("--{long}{values}")
}

/// What is most likely meant by an argument that is none of `verb`.
fn tip(unknown: &str, verb: Option<&str>, args: &[OsString]) -> Option<String> {
    let root = Args::command();
    let command = verb.and_then(|verb| root.find_subcommand(verb)).unwrap_or(&root);
    let option = unknown.trim_start_matches('-');
    if option == unknown {
        let in_quotes = || "a glob must be in quotes, or the shell replaces it by names".into();
        return similar_verb(args).filter(|_| verb.is_none()).or_else(|| Some(in_quotes()));
    }
    // What clap has cut into letters is perhaps the name of a file.
    let whole = args.iter().filter_map(|arg| arg.to_str()).find(|arg| arg.starts_with(unknown)).unwrap_or(unknown);
    if Path::new(whole).exists() {
        return Some(format!("write ./{} for the file of that name", plain(whole)));
    }
    let known = longs(command);
    let names: Vec<_> = known.iter().map(|(long, _)| *long).collect();
    let shown = |long: &str| known.iter().find(|(name, _)| *name == long).map(with_value).unwrap_or_default();
    match ours(option, &names) {
        Some("disp") => {
            return Some(format!(
                "{} is how many disparities are searched, --min-disp the smallest one",
                shown("disp")
            ));
        }
        Some(long) => return Some(format!("take {}", shown(long))),
        None => {}
    }
    // As other programs switch things off.
    let off = squeezed(option).strip_prefix("no").and_then(|rest| ours(rest, &names));
    if let Some(long) = off.filter(|long| value(long, "off") == Some("off")) {
        return Some(format!("take --{long} off"));
    }
    match squeezed(option).as_str() {
        "left" | "right" | "l" | "r" | "leftimage" | "rightimage" | "leftimg" | "rightimg" | "input" | "inputleft"
        | "inputright" | "i" | "images" => {
            return Some("the images are given without an option, the left one first".into());
        }
        "gpu" | "cpu" if names.contains(&"backend") => return Some(format!("take --backend {}", squeezed(option))),
        _ => {}
    }
    elsewhere(option, &root, command)
        .or_else(|| near(option, names.iter().copied()).map(|long| format!("a similar option is {}", shown(long))))
}

/// Which other commands have an option.
fn elsewhere(option: &str, root: &Command, command: &Command) -> Option<String> {
    let mut found = None;
    let mut places = Vec::new();
    for other in [root].into_iter().chain(root.get_subcommands()).filter(|other| other.get_name() != command.get_name())
    {
        let known = longs(other);
        let names: Vec<_> = known.iter().map(|(long, _)| *long).collect();
        let Some(place) = ours(option, &names).and_then(|long| names.iter().position(|name| *name == long)) else {
            continue;
        };
        found.get_or_insert_with(|| with_value(&known[place]));
        places.push(if other.get_name() == root.get_name() { "a single run" } else { other.get_name() });
    }
    found.map(|found| format!("{found} is an option of {}, not of this", places.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser as _;

    /// What is said of a command line.
    fn told(line: &str) -> String {
        let args: Vec<OsString> = line.split(' ').map(Into::into).collect();
        let all = [OsString::from("gpu-stereo")].into_iter().chain(args.clone());
        error_line(Args::try_parse_from(all).unwrap_err(), &args)
    }

    #[test]
    fn names_of_other_programs_become_ours() {
        for (given, ours) in [
            ("--max-disp", "--disp <N> is how many"),
            ("--max-disparity=64", "--disp <N> is how many"),
            ("--numDisparities", "--disp <N> is how many"),
            ("--num-disparities", "--disp <N> is how many"),
            ("--ndisp", "--disp <N> is how many"),
            ("--disparities", "--disp <N> is how many"),
            ("-d", "--disp <N> is how many"),
            ("--min_disp", "take --min-disp"),
            ("--minDisparity", "take --min-disp"),
            ("--blockSize", "take --block"),
            ("--block-size", "take --block"),
            ("--window", "take --block"),
            ("--P1", "take --p1"),
            ("--lr", "take --lr-check"),
            ("--disp12MaxDiff", "take --lr-check"),
            ("--speckleWindowSize", "take --speckle-window"),
            ("--speckle-size", "take --speckle-window"),
            ("--uniquenessRatio", "take --uniqueness"),
            ("--preFilterCap", "take --prefilter-cap"),
            ("--out", "take --output <FILE>"),
            ("--output-dir", "take --output <FILE>"),
            ("--gpu", "take --backend gpu"),
            ("--cpu", "take --backend cpu"),
            ("--device", "take --adapter <NAME-OR-INDEX>"),
            ("--left", "without an option"),
            ("--no-subpixel", "take --subpixel off"),
            ("--no_median", "take --median off"),
            ("--uniquness", "a similar option is --uniqueness"),
            ("--fps", "--fps <FPS> is an option of video, not of this"),
            ("--jobs", "--threads <N> is an option of batch, not of this"),
            ("--scale", "--scale <S> is an option of eval, not of this"),
        ] {
            let line = told(&format!("l.png r.png {given}"));
            assert!(line.contains(&format!("; {ours}")) || line.contains(ours), "{given}: {line}");
            assert!(
                line.starts_with("error: unexpected argument '-") && line.ends_with("; see gpu-stereo --help"),
                "{line}"
            );
            assert!(!line.contains("tip:") && !line.contains("'--min-disp'"), "{line}");
        }
        for (line, words) in [
            ("video l r -o m --output-dir x", "take --output <OUT>; see gpu-stereo video --help"),
            ("video l r -o m --calib x", "--calib <FILE> is an option of a single run, not of this"),
            ("sweep l r --max-disp 9", "--disp <N> is how many"),
            ("compare l r --variant sad", "a similar option is --variants"),
            ("bench d --layout kitti", "a similar value is"),
            ("eval a b --disp 9", "--disp <N> is an option of a single run, sweep, compare, bench, video, batch"),
            ("vidoe l r", "a similar verb is video"),
        ] {
            let line = told(line);
            assert!(line.contains(words) || words == "a similar value is", "{line}");
        }
    }

    #[test]
    fn what_is_not_near_has_no_tip() {
        for given in ["--frobnicate", "--max-disk-space", "--p3", "--cz", "-x", "--on"] {
            let line = told(&format!("l.png r.png {given}"));
            assert!(line.ends_with(&format!("unexpected argument '{given}' found; see gpu-stereo --help")), "{line}");
        }
        assert!(!told("l r --backend cuda").contains("similar"));
        assert!(told("l r --backend gpuu").contains("a similar value is gpu"));
        assert_eq!(near("min-dips", ["min-disp"].into_iter()), Some("min-disp"));
        assert_eq!(near("max-disp", ["min-disp"].into_iter()), None);
        assert_eq!(near("left-view", ["right-view"].into_iter()), None);
    }

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
    fn every_tip_names_an_option_that_exists() {
        let root = Args::command();
        let all: Vec<&str> =
            [&root].into_iter().chain(root.get_subcommands()).flat_map(longs).map(|(long, _)| long).collect();
        for (ours, others) in FOREIGN {
            assert!(all.contains(ours), "--{ours}");
            assert!(others.split(' ').all(|other| squeezed(other) == other), "{others}");
        }
    }

    #[test]
    fn what_was_typed_is_shown_and_not_obeyed() {
        for line in [
            "--\u{1b}[2J",
            "l r --disp\u{9b}",
            "l r --backend a\nerror:",
            "video l r -o x --fps\r 3",
            "l r third\u{1b}[31m",
        ] {
            let line = told(line);
            assert!(!line.contains(crate::terminal::is_obeyed), "{line:?}");
        }
    }
}
