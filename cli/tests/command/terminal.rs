//! What the command prints and refuses, whatever names it is given: no control character reaches stdout or
//! stderr, each output is judged before any work, and a tip never misleads. On the CPU, so no adapter is needed.

use crate::support::{command, contents, is_one_line_error, refuses, run, scene, stderr, stdout, succeeds};
use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::Path;
use std::process::Output;

/// Control characters, and lines that the command might have written.
const HOSTILE: [&str; 2] = [
    "a\u{1b}[2J\u{1b}]0;x\u{7}\u{8}\u{9b}2J\u{202e}b\u{2066}\u{200b}\u{feff}\u{7f}\u{9c}c",
    "a\nwritten  forged.png\nerror: forged\rfailed: forged\u{85}error: forged\u{2028}note: forged\u{2029}error: forged",
];

/// These, and on systems whose names need not be Unicode one that is not.
fn hostile() -> Vec<OsString> {
    #[allow(unused_mut)]
    let mut names: Vec<OsString> = HOSTILE.iter().map(Into::into).collect();
    #[cfg(target_os = "linux")]
    {
        use std::os::unix::ffi::OsStrExt as _;
        names.push(OsStr::from_bytes(b"a\xff\x9b2J\xc2").into());
    }
    names
}

fn with(name: &OsStr, ending: &str) -> OsString {
    let mut name = name.to_owned();
    name.push(ending);
    name
}

/// No control characters, and no line that a name forged.
#[track_caller]
fn is_clean(output: &Output, what: &str) {
    let code = output.status.code();
    assert!(matches!(code, Some(0..=2)), "{what}: {code:?}");
    for (stream, bytes) in [("stdout", &output.stdout), ("stderr", &output.stderr)] {
        let text = String::from_utf8(bytes.clone()).unwrap_or_else(|_| panic!("{what}: {stream} is no Unicode"));
        let obeyed = |c: char| {
            (c.is_control() && c != '\n')
                || ('\u{200b}'..='\u{200f}').contains(&c)
                || ('\u{2028}'..='\u{202e}').contains(&c)
                || ('\u{2060}'..='\u{206f}').contains(&c)
                || c == '\u{feff}'
        };
        assert!(!text.contains(obeyed), "{what}: {stream} has {:?}", text.chars().find(|c| obeyed(*c)));
        for line in text.lines() {
            let forged = ["written  forged", "error: forged", "failed: forged", "note: forged"];
            assert!(!forged.iter().any(|forged| line.starts_with(forged)), "{what}: {stream} has the line {line}");
        }
        assert!(!text.contains("this is a bug"), "{what}: {text}");
    }
}

const TO_16: [&str; 4] = ["--disp", "16", "--backend", "cpu"];

fn args(first: &[&OsStr], more: &[&str]) -> Vec<OsString> {
    first.iter().map(|arg| (*arg).to_owned()).chain(more.iter().map(Into::into)).collect()
}

#[test]
fn names_in_a_single_run() {
    for name in hostile() {
        let folder = scene();
        let at = |name: &OsStr| folder.path().join(name);
        let [l, r, o, c] = ["l.png", "r.png", "o.png", "c.png"].map(|ending| with(&name, ending));
        fs::copy(at("left.png".as_ref()), at(&l)).unwrap();
        fs::copy(at("right.png".as_ref()), at(&r)).unwrap();
        for more in [&["--timings"][..], &["--json"], &["-q"]] {
            let all = [&[&l, &r, OsStr::new("-o"), &o, OsStr::new("--color"), &c][..], &[]].concat();
            let output = run(folder.path(), &args(&all, &[&TO_16[..], more].concat()));
            is_clean(&output, "a good run");
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
            assert!(at(&o).exists() && at(&c).exists());
            if more == ["--json"] {
                let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
                assert_eq!(told["outputs"][0], o.to_string_lossy().as_ref());
            }
        }
        // Every position of a name, and of a word.
        let (left, right) = (OsStr::new("left.png"), OsStr::new("right.png"));
        for [left, right] in [[&*name, right], [left, &*name]] {
            is_clean(&run(folder.path(), &args(&[left, right], &TO_16)), "a missing image");
        }
        for option in [
            "-o",
            "--color",
            "--mask",
            "--confidence",
            "--error-map",
            "--depth",
            "--points",
            "--gt",
            "--gt-mask",
            "--gt-scale",
            "--calib",
            "--rectify",
            "--calib-right",
            "--calib-unit",
            "--calib-pair",
            "--focal",
            "--cx",
            "--backend",
            "--adapter",
            "--repeat",
            "--preset",
            "--method",
            "--cost",
            "--disp",
            "--min-disp",
            "--block",
            "--fill",
        ] {
            for ending in ["", ".png", "/x.png"] {
                let given = with(&name, ending);
                let to = match option {
                    "--disp" => &TO_16[2..],
                    "--backend" | "--adapter" => &TO_16[..2],
                    _ => &TO_16,
                };
                let mut all = args(&[left, right], to);
                all.extend([option.into(), given]);
                is_clean(&run(folder.path(), &all), option);
            }
        }
        for odd in ["--", "-", "--disp=", "sweep", ""] {
            let mut odd = OsString::from(odd);
            odd.push(&name);
            is_clean(&run(folder.path(), &args(&[left, right, &odd], &TO_16)), "an argument too many");
            is_clean(&run(folder.path(), &args(&[&odd, left, right], &TO_16)), "an argument too many");
        }
        // What is in files.
        let text = name.to_string_lossy();
        for (file, text) in [
            ("c.txt", format!("cam0=[{text}]\ncam1=[1]\nbaseline={text}\n")),
            ("k.txt", format!("P2{text}: 1 2 3\nP3: {text} 1 2\n")),
            ("c.yml", format!("%YAML:1.0\nP1: {text:?}\n{text}: [\n")),
            ("c.xml", format!("<a><{text}/>{text}</b>")),
            ("c.json", format!("{{{text:?}: 1}}")),
        ] {
            fs::write(at(file.as_ref()), text).unwrap();
            for option in ["--calib", "--rectify", "--gt"] {
                is_clean(
                    &run(
                        folder.path(),
                        &args(&[left, right], &[&TO_16[..], &[option, file, "--depth", "d.npy"]].concat()),
                    ),
                    file,
                );
            }
        }
    }
}

#[test]
fn names_in_the_verbs() {
    for name in hostile() {
        let folder = scene();
        let at = |name: &OsStr| folder.path().join(name);
        let [l, r, o] = ["l", "r", "o"].map(|ending| with(&name, ending));
        for (side, image) in [(&l, "left.png"), (&r, "right.png")] {
            fs::create_dir(at(side)).unwrap();
            fs::copy(at(image.as_ref()), at(side).join(with(&name, "1.png"))).unwrap();
            fs::copy(at(image.as_ref()), at(side).join(with(&name, "2.png"))).unwrap();
        }
        let o_option = OsStr::new("-o");
        let video = args(&["video".as_ref(), &l, &r, o_option, &o], &TO_16);
        let output = run(folder.path(), &video);
        is_clean(&output, "video");
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        fs::write(at(&l).join(with(&name, "2.png")), "no image").unwrap();
        for (verb, more) in [("video", &["--json"][..]), ("video", &[]), ("batch", &[]), ("batch", &["--json"])] {
            let out = with(&o, verb);
            let output =
                run(folder.path(), &args(&[verb.as_ref(), &l, &r, o_option, &out], &[&TO_16[..], more].concat()));
            is_clean(&output, verb);
            assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
            assert!(stderr(&output).lines().any(|line| line.starts_with("failed: ")), "{}", stderr(&output));
        }
        for log in ["failures.jsonl", "done.jsonl", "gpu-stereo.json"] {
            if let Ok(text) = fs::read_to_string(at(&with(&o, "batch")).join(log)) {
                assert!(!text.contains(|c: char| c.is_control() && c != '\n'), "{log}");
            }
        }
        for given in ["", "/*.png", "/%d.png", "[x", ".mp4", "/x/%d.png", ".csv", ".jsonl"] {
            let given = with(&name, given);
            for verb in ["video", "batch"] {
                is_clean(&run(folder.path(), &args(&[verb.as_ref(), &given, &r, o_option, &o], &TO_16)), verb);
                is_clean(&run(folder.path(), &args(&[verb.as_ref(), &given, o_option, &o], &TO_16)), verb);
                is_clean(&run(folder.path(), &args(&[verb.as_ref(), &r, &r, o_option, &given], &TO_16)), verb);
            }
        }
        let text = name.to_string_lossy().into_owned();
        let line =
            |left: &str, name: &str| serde_json::json!({"left": left, "right": "right.png", "name": name}).to_string();
        for (file, lines) in [
            ("missing.jsonl", line(&text, "a")),
            ("name.jsonl", line("left.png", &text)),
            ("same.jsonl", [line("left.png", "a"), line(&text, "a")].join("\n")),
            ("key.jsonl", serde_json::json!({text.as_str(): "x"}).to_string()),
            ("list.csv", format!("left.png,\"{}\"\nleft.png,b,c,{text}\n", text.replace(['\n', '\r'], ""))),
            ("header.csv", format!("left,right,{}\n", text.replace(['\n', '\r'], ""))),
        ] {
            fs::write(at(file.as_ref()), lines).unwrap();
            is_clean(
                &run(folder.path(), &args(&["batch".as_ref(), file.as_ref(), o_option, &with(&o, file)], &TO_16)),
                file,
            );
        }
        for option in ["--format", "--fps", "--in-flight", "--shard", "--threads", "--resume"] {
            for verb in ["video", "batch"] {
                let all = args(&[verb.as_ref(), &l, &r, o_option, &o, option.as_ref(), &name], &TO_16);
                is_clean(&run(folder.path(), &all), option);
            }
        }
        let (left, right) = (OsStr::new("left.png"), OsStr::new("right.png"));
        for given in [&name, &with(&name, ".safetensors")] {
            let [weights, convert, image] = ["weights", "--convert", "left.png"].map(OsStr::new);
            is_clean(&run(folder.path(), &args(&[weights, given], &[])), "weights");
            is_clean(&run(folder.path(), &args(&[weights, image, convert, given], &[])), "weights");
            let network = [&TO_16[..], &["--method", "psmnet", "--weights"]].concat();
            let all = [args(&[image, image], &network), vec![given.clone()]].concat();
            is_clean(&run(folder.path(), &all), "a network");
        }
        for (verb, more) in [
            ("sweep", &["--block"][..]),
            ("sweep", &["-o"]),
            ("sweep", &["--tile-width"]),
            ("compare", &["--variants"]),
            ("compare", &["--variants", "sad", "-o"]),
            ("eval", &["--scale"]),
            ("eval", &["--error-map"]),
            ("eval", &["--gt-mask"]),
        ] {
            let to = if verb == "eval" { &[][..] } else { &TO_16 };
            let all = [args(&[verb.as_ref(), left, right], &[to, more].concat()), vec![name.clone()]].concat();
            is_clean(&run(folder.path(), &all), verb);
            is_clean(&run(folder.path(), &args(&[verb.as_ref(), &name, right], to)), verb);
        }
        let sheet = with(&name, "s.png");
        let output = run(folder.path(), &args(&["sweep".as_ref(), left, right, o_option, &sheet], &TO_16));
        is_clean(&output, "sweep");
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        // A data set.
        let scene = |scene: &str, left: &str| serde_json::json!({"set": text, "scene": scene, "left": left, "right": "right.png"});
        let (good, bad) = (scene(&text, "left.png"), scene("b", &text));
        fs::write(at("MANIFEST.json".as_ref()), serde_json::json!([good, bad]).to_string()).unwrap();
        let report = with(&name, "report");
        for more in [&["--json"][..], &[]] {
            let all = args(
                &["bench".as_ref(), ".".as_ref(), "--report".as_ref(), &report],
                &[&TO_16[..], &["--layout", "manifest"], more].concat(),
            );
            let output = run(folder.path(), &all);
            is_clean(&output, "bench");
            assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
            for file in ["report.md", "results.json"] {
                let text = fs::read_to_string(at(&report).join(file)).unwrap();
                assert!(!text.contains(|c: char| c.is_control() && c != '\n'), "{file}");
                assert!(!text.lines().any(|line| line.starts_with("error: forged")), "{file}");
            }
        }
        for option in ["--only", "--variants", "--layout", "--method-name", "--submission", "--report"] {
            let all = args(
                &["bench".as_ref(), ".".as_ref(), option.as_ref(), &name],
                &["--layout", "manifest", "--backend", "cpu"],
            );
            is_clean(&run(folder.path(), &all), option);
        }
        for entries in [
            serde_json::json!([scene("a", "l"), scene("a", "l")]),
            serde_json::json!([{"set": text, "scene": text, "left": "l", "right": "r", "max_disp": -1}]),
            serde_json::json!([{text.as_str(): text}]),
        ] {
            fs::write(at("bad.json".as_ref()), entries.to_string()).unwrap();
            let all = args(&["bench".as_ref(), "bad.json".as_ref()], &["--layout", "manifest", "--backend", "cpu"]);
            is_clean(&run(folder.path(), &all), "a bad manifest");
        }
    }
}

/// What in a source prints past the module that prints, or prints a path as it is.
fn faults(source: &str) -> Vec<&'static str> {
    let code = source.split("#[cfg(test)]\nmod tests").next().unwrap();
    ["println!", "print!(", "eprint!(", "dbg!(", "(stdout()", "(stderr()", ".display()", "io::stdout", "io::stderr"]
        .into_iter()
        .filter(|fault| code.contains(fault))
        .collect()
}

fn sources(folder: &Path) -> Vec<(String, String)> {
    let mut all = Vec::new();
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            all.extend(sources(&path));
        } else if path.file_name() != Some("tests.rs".as_ref()) {
            all.push((path.to_string_lossy().replace('\\', "/"), fs::read_to_string(&path).unwrap()));
        }
    }
    all
}

#[test]
fn one_module_prints() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let all = [sources(&root.join("src")), sources(&root.join("../src/files"))].concat();
    let (printing, others): (Vec<_>, Vec<_>) =
        all.into_iter().partition(|(path, _)| path.contains("cli/src/terminal/"));
    assert!(others.len() > 60 && printing.iter().any(|(_, source)| !faults(source).is_empty()));
    for (path, source) in &others {
        assert_eq!(
            faults(source),
            Vec::<&str>::new(),
            "{path} prints by itself; use terminal::message, terminal::print and terminal::name"
        );
    }
    let source = &others[0].1;
    for mutant in [
        "println!(\"{path}\");",
        "eprintln!(\"{path}\");",
        "writeln!(std::io::stderr(), \"{path}\")?;",
        "let text = path.display();",
    ] {
        assert!(!faults(&format!("fn f() {{ {mutant} }}\n{source}")).is_empty(), "{mutant}");
    }
}

// Outputs.

/// Before any image is looked at, since there is none.
#[test]
fn outputs_are_judged_before_any_work() {
    let folder = scene();
    let at = |name: &str| folder.path().join(name);
    fs::hard_link(at("left.png"), at("hard.png")).unwrap();
    fs::write(at("cal.pfm"), "cam0=[9 0 4; 0 9 4; 0 0 1]\ncam1=[9 0 4; 0 9 4; 0 0 1]\nbaseline=100\n").unwrap();
    fs::write(at("truth.png"), "no image").unwrap();
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("nowhere/x.png", at("lost.png")).unwrap();
        std::os::unix::fs::symlink("new.png", at("dangling.png")).unwrap();
    }
    let rows: &[(&[&str], &[&str])] = &[
        (
            &["-o", "x.npy", "-o", "x.png", "--min-disp", "-12"],
            &["x.png", "16-bit PNG", "0 to 255.9375 px", "-12 to 3 px"],
        ),
        (&["-o", "x.png", "--min-disp", "241"], &["x.png", "241 to 256 px", ".pfm"]),
        (&["-o", "x.png/"], &["\"x.png/\"", "name of a folder"]),
        (&["-o", "~/x.png"], &["\"~\"", "does not exist", "quotes"]),
        (&["--mask", "file:///tmp/x.png"], &["does not exist", "not an address"]),
        (&["--depth", "d.npy"], &["--calib"]),
        (&["--depth", "cal.pfm", "--calib", "cal.pfm"], &["cal.pfm", "is an input"]),
        (&["--gt", "truth.png", "--error-map", "truth.png"], &["truth.png", "is an input"]),
        (&["--gt", "truth.pfm", "--gt-mask", "truth.png", "--color", "./truth.png"], &["truth.png", "is an input"]),
        (&["-o", "/dev/null"], &["/dev/null"]),
        #[cfg(unix)]
        (&["-o", "lost.png"], &["lost.png", "is a link to", "nowhere/x.png", "does not exist"]),
        #[cfg(unix)]
        (&["-o", "new.png", "--color", "dangling.png"], &["dangling.png", "twice"]),
    ];
    for (more, words) in rows {
        refuses(folder.path(), &[&["no.png", "none.png"], &TO_16[..], more].concat(), words);
    }
    for (more, words) in [(["-o", "hard.png"], "is an input"), (["--color", "hard.png"], "is an input")] {
        refuses(folder.path(), &[&["left.png", "none.png"], &TO_16[..], &more].concat(), &["hard.png", words]);
    }
    refuses(
        folder.path(),
        &[&["sweep", "left.png", "none.png", "-o", "hard.png"], &TO_16[..]].concat(),
        &["is an input"],
    );
    refuses(folder.path(), &["eval", "none.pfm", "truth.png", "--error-map", "truth.png"], &["is an input"]);
    refuses(folder.path(), &["eval", "none.pfm", "truth.png", "--error-map", "nowhere/x.png"], &["does not exist"]);
}

#[test]
fn ranges_that_a_format_cannot_hold_are_refused_before_any_frame() {
    let folder = scene();
    for side in ["l", "r"] {
        fs::create_dir(folder.path().join(side)).unwrap();
        fs::write(folder.path().join(side).join("1.png"), "no image").unwrap();
    }
    for (verb, out, more) in
        [("video", "m", &["--format", "npy,png"][..]), ("video", "m_%d.png", &[]), ("batch", "m", &["--format", "png"])]
    {
        for range in [["--min-disp", "-4"], ["--min-disp", "241"]] {
            let all = [&[verb, "l", "r", "-o", out], &TO_16[..], more, &range].concat();
            refuses(folder.path(), &all, &["16-bit PNG", "0 to 255.9375 px", ".npy"]);
        }
    }
}

#[cfg(unix)]
#[test]
fn a_dangling_link_stays_a_link_and_its_file_is_made() {
    let folder = scene();
    std::os::unix::fs::symlink("new.png", folder.path().join("dangling.png")).unwrap();
    succeeds(folder.path(), &[&["left.png", "right.png", "-o", "dangling.png", "-q"], &TO_16[..]].concat());
    assert!(fs::symlink_metadata(folder.path().join("dangling.png")).unwrap().is_symlink());
    assert!(fs::symlink_metadata(folder.path().join("new.png")).unwrap().is_file());
}

/// A data set of Middlebury's layout, and one of KITTI's.
#[test]
fn files_of_a_data_set_are_judged_before_any_work() {
    let folder = scene();
    let at = |name: &str| folder.path().join(name);
    for name in ["m/trainingQ/A", "k/training/image_2", "k/training/image_3", "report/report.md", "flat"] {
        fs::create_dir_all(at(name)).unwrap();
    }
    for name in ["m/trainingQ/A/im0.png", "m/trainingQ/A/im1.png", "m/trainingQ/A/disp0GT.pfm", "flat/pictures"] {
        fs::write(at(name), "nothing that can be read").unwrap();
    }
    for side in ["2", "3"] {
        fs::write(at(&format!("k/training/image_{side}/000000_10.png")), "nothing that can be read").unwrap();
    }
    let bench = |more: &[&str], words: &[&str]| {
        refuses(folder.path(), &[&["bench"], more, &["--backend", "cpu"]].concat(), words);
    };
    bench(
        &["m", "--layout", "middlebury", "--submission", "m", "--method-name", "GT"],
        &["disp0GT.pfm", "is an input"],
    );
    bench(&["m", "--layout", "middlebury", "--report", "report"], &["report.md", "is a folder"]);
    bench(&["m", "--layout", "middlebury", "--report", "flat"], &["pictures", "is a file"]);
    bench(&["k", "--layout", "kitti2015", "--submission", "s", "--min-disp", "-4"], &["16-bit PNG", "-4 to 187 px"]);
}

#[test]
fn names_too_long_are_refused_before_any_work() {
    let folder = scene();
    let name = "n".repeat(251);
    fs::write(folder.path().join("list.csv"), format!("no.png,none.png,{name}/x\nno.png,none.png,{name}y\n")).unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    fs::write(folder.path().join("in.csv"), "no.png,none.png,file/x\n").unwrap();
    let batch = |list: &str, out: &str, words: &[&str]| {
        refuses(folder.path(), &[&["batch", list, "-o", out], &TO_16[..]].concat(), words);
    };
    batch("list.csv", "out", &["256 bytes", "255"]);
    batch("in.csv", ".", &["file", "which is not a folder"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_stdout_says_that_the_files_are_written() {
    let folder = scene();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let args = [&["left.png", "right.png", "-o", "a.png"], &TO_16[..]].concat();
    let output = command(folder.path()).args(args).stdout(full).output().unwrap();
    is_one_line_error(&output, &["the files were written, but not the report", "stdout"]);
    assert!(folder.path().join("a.png").exists());
}

// The environment.

#[test]
fn variables_that_mean_nothing_are_refused_by_name() {
    let folder = scene();
    let with = |variable: &str, value: &str, args: &[&str]| {
        command(folder.path()).env(variable, value).args(args).output().unwrap()
    };
    let auto = ["left.png", "right.png", "--disp", "16", "-o", "a.npy"];
    for args in [&auto[..], &["--list-adapters"], &["sweep", "left.png", "right.png", "--disp", "16"]] {
        is_one_line_error(
            &with("WGPU_BACKEND", "vulcan", args),
            &["WGPU_BACKEND=\"vulcan\"", "vulkan, metal, dx12, gl"],
        );
    }
    is_one_line_error(&with("WGPU_BACKEND", "noop", &auto), &["WGPU_BACKEND=\"noop\""]);
    is_one_line_error(&with("WGPU_BACKEND", "a\u{1b}[2J\nb", &auto), &["WGPU_BACKEND=\"a\\u{1b}[2J\\nb\""]);
    is_one_line_error(
        &with("WGPU_GLES_MINOR_VERSION", "7", &auto),
        &["WGPU_GLES_MINOR_VERSION=\"7\"", "automatic, 0, 1, 2"],
    );
    #[cfg(target_os = "linux")]
    is_one_line_error(&with("WGPU_BACKEND", "metal", &auto), &["WGPU_BACKEND=\"metal\"", "here are only vulkan, gl"]);
    assert!(!folder.path().join("a.npy").exists());
    // The reference asks for no adapter.
    let cpu = [&auto[..], &["--backend", "cpu"]].concat();
    assert_eq!(with("WGPU_BACKEND", "vulcan", &cpu).status.code(), Some(0));
    let told = with("WGPU_ADAPTER_NAME", "any", &auto);
    assert!(
        stderr(&told).contains("note: the environment has WGPU_ADAPTER_NAME=\"any\", which has no effect"),
        "{}",
        stderr(&told)
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_search_that_the_environment_leads_nowhere_says_so() {
    let folder = scene();
    let none = |args: &[&str]| {
        let mut command = command(folder.path());
        command.env("VK_DRIVER_FILES", "/nonexistent").env_remove("VK_ICD_FILENAMES").env_remove("WGPU_BACKEND");
        command.args(args).output().unwrap()
    };
    let mut disabled = command(folder.path());
    disabled.args(["left.png", "right.png", "--disp", "16", "--backend", "gpu"]).env("VK_LOADER_DRIVERS_DISABLE", "*");
    let output = disabled.env("VK_DRIVER_FILES", "/nonexistent").output().unwrap();
    is_one_line_error(&output, &["VK_LOADER_DRIVERS_DISABLE=\"*\" and VK_DRIVER_FILES"]);
    let words = "VK_DRIVER_FILES=\"/nonexistent\", where no file is";
    is_one_line_error(
        &none(&["left.png", "right.png", "--disp", "16", "--backend", "gpu"]),
        &[words, "no usable adapter"],
    );
    is_one_line_error(&none(&["left.png", "right.png", "--disp", "16", "--adapter", "0"]), &[words, "no adapter"]);
    for args in [&["--list-adapters"][..], &["left.png", "right.png", "--disp", "16", "-o", "a.npy"]] {
        let told = none(args);
        assert_eq!((told.status.code(), stderr(&told).contains(words)), (Some(0), true), "{}", stderr(&told));
    }
}

/// The address space ends before the threads do.
#[cfg(target_os = "linux")]
#[test]
fn too_few_threads_are_an_error_in_one_line() {
    let folder = scene();
    let script = "ulimit -v 2000000; exec \"$0\" left.png right.png --disp 16 --backend cpu";
    let mut limited = std::process::Command::new("sh");
    limited.args(["-c", script, env!("CARGO_BIN_EXE_gpu-stereo")]).current_dir(folder.path());
    let before = contents(folder.path());
    // Large stacks, so that what is left when one more does not fit holds all else that the others take.
    let output = limited.env("RAYON_NUM_THREADS", "20000").env("RUST_MIN_STACK", "500000000").output().unwrap();
    is_one_line_error(&output, &["threads", "cannot be started", "ulimit -u", "RAYON_NUM_THREADS=1"]);
    assert!(contents(folder.path()) == before);
}

// Patterns and tips.

#[test]
fn folders_with_brackets_and_per_cent_signs_are_folders() {
    let folder = scene();
    for (side, image) in
        [("l [0]", "left.png"), ("r [0]", "right.png"), ("100%_l", "left.png"), ("100%_r", "right.png")]
    {
        fs::create_dir(folder.path().join(side)).unwrap();
        fs::copy(folder.path().join(image), folder.path().join(side).join("1.png")).unwrap();
    }
    for (i, [left, right]) in [
        ["l [0]/*.png", "r [0]/*.png"],
        ["l [0]", "r [0]"],
        ["l [0]/%d.png", "r [0]/%d.png"],
        ["l [0]/1.png", "r [0]/1.png"],
        ["100%_l/%d.png", "100%_r/%d.png"],
        ["100%_l/*.png", "100%_r/*.png"],
    ]
    .into_iter()
    .enumerate()
    {
        for verb in ["video", "batch"] {
            let out = format!("{verb}{i}");
            let told = succeeds(folder.path(), &[&[verb, left, right, "-o", &out], &TO_16[..]].concat());
            assert!(stdout(&told).contains("1 done, 0 failed"), "{left}: {}", stdout(&told));
        }
    }
    let out = ["video", "l [0]", "r [0]", "-o", "100%_l/map_%03d.npy"];
    succeeds(folder.path(), &[&out, &TO_16[..]].concat());
    assert!(folder.path().join("100%_l/map_000.npy").exists());
    let none = [&["video", "l [0]/*.jpg", "r [0]/*.jpg", "-o", "m"], &TO_16[..]].concat();
    refuses(folder.path(), &none, &["\"l [0]\" has \"1.png\", for example", "nothing like \"*.jpg\"", "[[]"]);
}

#[test]
fn tips_do_not_mislead() {
    let folder = scene();
    let told = |args: &[&str]| {
        let output = run(folder.path(), args);
        is_one_line_error(&output, &["--help"]);
        stderr(&output)
    };
    let single = told(&["left.png", "right.png", "--max-disp", "64"]);
    assert!(
        single.contains("--disp <N> is how many disparities are searched") && !single.contains("similar"),
        "{single}"
    );
    assert!(told(&["left.png", "right.png", "--disp", "16", "--backend", "cuda"]).find("similar").is_none());
    assert!(told(&["left.png", "right.png", "--disp", "16", "--method", "sgbm"]).contains("; use sgm; "));
    assert!(told(&["eval", "a", "b", "--disp", "16"]).contains("--disp <N> is an option of a single run, sweep"));
    fs::copy(folder.path().join("left.png"), folder.path().join("-left.png")).unwrap();
    assert!(told(&["-left.png", "right.png", "--disp", "16"]).contains("write ./-left.png"));
    refuses(
        folder.path(),
        &["~/l.png", "right.png", "--disp", "16", "--backend", "cpu"],
        &["does not exist", "quotes"],
    );
    refuses(folder.path(), &["file:///l.png", "right.png", "--disp", "16", "--backend", "cpu"], &["not an address"]);
    #[cfg(unix)]
    refuses(folder.path(), &["C:\\l.png", "right.png", "--disp", "16", "--backend", "cpu"], &["/ instead of \\"]);
}
