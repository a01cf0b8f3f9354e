use super::tips::longs;
use super::*;
use crate::args::FOREIGN;
use crate::args::squeezed;
use crate::terminal;
use std::ffi::OsString;

/// What is said of a command line.
fn told(line: &str) -> String {
    let args: Vec<OsString> = line.split(' ').map(Into::into).collect();
    let all = [OsString::from("gpu-stereo")].into_iter().chain(args.clone());
    tips::error_line(CommandLine::try_parse_from(all).unwrap_err(), &CommandLine::command(), &args)
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
        ("--min_disp", "use --min-disp"),
        ("--minDisparity", "use --min-disp"),
        ("--blockSize", "use --block"),
        ("--block-size", "use --block"),
        ("--window", "use --block"),
        ("--P1", "use --p1"),
        ("--lr", "use --lr-check"),
        ("--disp12MaxDiff", "use --lr-check"),
        ("--speckleWindowSize", "use --speckle-window"),
        ("--speckle-size", "use --speckle-window"),
        ("--uniquenessRatio", "use --uniqueness"),
        ("--preFilterCap", "use --prefilter-cap"),
        ("--out", "use --output <FILE>"),
        ("--output-dir", "use --output <FILE>"),
        ("--gpu", "use --backend gpu"),
        ("--cpu", "use --backend cpu"),
        ("--device", "use --adapter <NAME-OR-INDEX>"),
        ("--left", "without an option"),
        ("--no-subpixel", "use --subpixel off"),
        ("--no_median", "use --median off"),
        ("--uniquness", "a similar option is --uniqueness"),
        ("--fps", "--fps <FPS> is an option of video, not of this"),
        ("--jobs", "--threads <N> is an option of batch, not of this"),
        ("--scale", "--scale <S> is an option of eval, not of this"),
    ] {
        let line = told(&format!("l.png r.png {given}"));
        assert!(line.contains(&format!("; {ours}")) || line.contains(ours), "{given}: {line}");
        assert!(line.starts_with("unexpected argument '-") && line.ends_with("; see gpu-stereo --help"), "{line}");
        assert!(!line.contains("tip:") && !line.contains("'--min-disp'"), "{line}");
    }
    for (line, words) in [
        ("video l r -o m --output-dir x", "use --output <OUT>; see gpu-stereo video --help"),
        ("video l r -o m --check", "--check is an option of a single run, not of this"),
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
}

#[test]
fn every_tip_names_an_option_that_exists() {
    let root = CommandLine::command();
    let all: Vec<&str> =
        [&root].into_iter().chain(root.get_subcommands()).flat_map(longs).map(|(long, _)| long).collect();
    for (ours, others) in FOREIGN {
        assert!(all.contains(ours), "--{ours}");
        assert!(others.split(' ').all(|other| squeezed(other) == other), "{others}");
    }
}

#[test]
fn what_was_typed_is_escaped() {
    for line in [
        "--\u{1b}[2J",
        "l r --disp\u{9b}",
        "l r --backend a\nerror:",
        "video l r -o x --fps\r 3",
        "l r third\u{1b}[31m",
    ] {
        let line = told(line);
        assert!(!line.contains(terminal::must_be_escaped), "{line:?}");
    }
}

#[test]
fn the_command_is_well_formed() {
    CommandLine::command().debug_assert();
}
