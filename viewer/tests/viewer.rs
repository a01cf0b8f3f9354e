//! The viewer as a user meets it: the built program on a screen of its own (Xvfb), moved by a pointer, its pixels
//! compared with what the library computes. Equality is exact.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "../../tests/support/mod.rs"]
mod support;

#[allow(dead_code, missing_docs)]
#[path = "../src/files.rs"]
mod files;
#[allow(dead_code, missing_docs)]
#[path = "../src/panel.rs"]
mod panel;

use std::collections::HashSet;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use gpu_stereo::{DisparityMap, Params, Preset, StereoMatcher};
use image::{GrayImage, Luma, RgbImage};
use x11rb::connection::Connection as _;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    AtomEnum, ClientMessageEvent, ConnectionExt as _, CreateWindowAux, EventMask, ImageFormat, PropMode,
    SELECTION_NOTIFY_EVENT, SelectionNotifyEvent, Window, WindowClass,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

/// Far beyond what anything takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(40);

/// A screen that nobody sees.
struct Screen {
    xvfb: Child,
    name: String,
    x: RustConnection,
    root: Window,
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = self.xvfb.kill();
        let _ = self.xvfb.wait();
    }
}

impl Screen {
    /// `None` only where there is no Xvfb, or no adapter, and the environment allows that.
    fn new() -> Option<Self> {
        support::device()?;
        let mut command = Command::new("Xvfb");
        command.args(["-displayfd", "1", "-screen", "0", "1400x1000x24", "-nolisten", "tcp", "-noreset"]);
        let Ok(mut xvfb) = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn() else {
            assert!(
                std::env::var_os("GPU_STEREO_NO_DISPLAY").is_some(),
                "Xvfb was not found: install it (Debian: xvfb), or set GPU_STEREO_NO_DISPLAY=1 to go on without the \
                 tests that need a screen"
            );
            let _ = writeln!(std::io::stderr(), "NOT TESTED: there is no Xvfb, and GPU_STEREO_NO_DISPLAY is set");
            return None;
        };
        let mut number = String::new();
        BufReader::new(xvfb.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let name = format!(":{}", number.trim());
        let (x, screen) = x11rb::connect(Some(&name)).expect("Xvfb answers");
        let root = x.setup().roots[screen].root;
        Some(Self { xvfb, name, x, root })
    }

    /// The pixels of a rectangle, red, green and blue each.
    fn pixels(&self, [x, y, width, height]: [u32; 4]) -> Vec<[u8; 3]> {
        let image = self
            .x
            .get_image(ImageFormat::Z_PIXMAP, self.root, x as i16, y as i16, width as u16, height as u16, !0)
            .unwrap()
            .reply()
            .unwrap();
        assert_eq!((image.depth, image.data.len()), (24, (4 * width * height) as usize));
        image.data.chunks_exact(4).map(|bgr| [bgr[2], bgr[1], bgr[0]]).collect()
    }

    /// Waits until the rectangle looks so: what is presented reaches the screen a little later.
    fn shows(&self, at: [u32; 4], expected: &[[u8; 3]], what: &str) {
        let until = Instant::now() + PATIENCE;
        loop {
            let seen = self.pixels(at);
            assert_eq!(seen.len(), expected.len(), "{what}");
            let wrong = || seen.iter().zip(expected).enumerate().filter(|(_, (seen, expected))| seen != expected);
            let Some((i, (seen, expected))) = wrong().next() else { return };
            let (x, y) = (i as u32 % at[2], i as u32 / at[2]);
            assert!(
                Instant::now() < until,
                "{what}: {} of {} pixels differ, first ({x}, {y}): expected {expected:?}, seen {seen:?}",
                wrong().count(),
                at[2] * at[3],
            );
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn fake(&self, kind: u8, detail: u8, x: u32, y: u32) {
        self.x.xtest_fake_input(kind, detail, 0, self.root, x as i16, y as i16, 0).unwrap();
        self.x.sync().unwrap();
        std::thread::sleep(Duration::from_millis(60)); // a frame of the window for each
    }

    fn point(&self, x: u32, y: u32) {
        self.fake(6, 0, x, y);
    }

    fn button(&self, down: bool) {
        self.fake(if down { 4 } else { 5 }, 1, 0, 0);
    }

    fn click(&self, [x, y]: [u32; 2]) {
        self.point(x, y);
        self.button(true);
        self.button(false);
    }

    fn atom(&self, name: &str) -> u32 {
        self.x.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom
    }

    /// The window below `from` that files can be dropped on.
    fn target(&self, from: Window) -> Option<Window> {
        let aware = self.atom("XdndAware");
        let properties = self.x.list_properties(from).unwrap().reply().ok()?.atoms;
        if properties.contains(&aware) {
            return Some(from);
        }
        self.x.query_tree(from).unwrap().reply().ok()?.children.into_iter().find_map(|child| self.target(child))
    }

    /// Drags files to the window and drops them, as a file manager does: the protocol XDND, version 5.
    fn drop_on_window(&self, paths: &[&Path]) {
        let target = self.target(self.root).expect("the window takes drops");
        let source = self.x.generate_id().unwrap();
        let look = CreateWindowAux::new().event_mask(EventMask::PROPERTY_CHANGE);
        self.x.create_window(0, source, self.root, 0, 0, 1, 1, 0, WindowClass::INPUT_OUTPUT, 0, &look).unwrap();
        let (selection, list) = (self.atom("XdndSelection"), self.atom("text/uri-list"));
        self.x.set_selection_owner(source, selection, 0u32).unwrap();
        let send = |name: &str, data: [u32; 4]| {
            let message =
                ClientMessageEvent::new(32, target, self.atom(name), [source, data[0], data[1], data[2], data[3]]);
            self.x.send_event(false, target, EventMask::NO_EVENT, message).unwrap();
            self.x.flush().unwrap();
        };
        send("XdndEnter", [5 << 24, list, 0, 0]);
        send("XdndPosition", [0, 700 << 16 | 500, 0, self.atom("XdndActionCopy")]);
        let (finished, until) = (self.atom("XdndFinished"), Instant::now() + PATIENCE);
        loop {
            match self.x.poll_for_event().unwrap() {
                Some(Event::SelectionRequest(asked)) => {
                    let uris: String = paths.iter().map(|path| format!("file://{}\r\n", path.display())).collect();
                    let (replace, kind) = (PropMode::REPLACE, AtomEnum::ANY);
                    assert_ne!(asked.target, u32::from(kind));
                    self.x.change_property8(replace, asked.requestor, asked.property, list, uris.as_bytes()).unwrap();
                    let notify = SelectionNotifyEvent {
                        response_type: SELECTION_NOTIFY_EVENT,
                        sequence: 0,
                        time: asked.time,
                        requestor: asked.requestor,
                        selection,
                        target: asked.target,
                        property: asked.property,
                    };
                    self.x.send_event(false, asked.requestor, EventMask::NO_EVENT, notify).unwrap();
                    send("XdndDrop", [0, 0, 0, 0]);
                }
                Some(Event::ClientMessage(message)) if message.type_ == finished => break,
                Some(_) => {}
                None => {
                    assert!(Instant::now() < until, "the drop was never finished");
                    std::thread::sleep(Duration::from_millis(5));
                }
            }
        }
        self.x.destroy_window(source).unwrap();
        self.x.flush().unwrap();
    }
}

fn command(display: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gpu-stereo-viewer"));
    command.env("NODEVICE_SELECT", "1"); // Mesa's layer writes on stderr where there is no desktop session
    command.args(arguments).env("DISPLAY", display).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// The program and the lines that it has told.
struct Viewer {
    child: Child,
    lines: Receiver<String>,
    told: Vec<String>,
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Viewer {
    fn new(screen: &Screen, arguments: &[&str]) -> Self {
        let mut child = command(&screen.name, &[&["--trace"], arguments].concat()).spawn().unwrap();
        let (sender, lines) = channel();
        let output = BufReader::new(child.stdout.take().unwrap());
        std::thread::spawn(move || output.lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
        Self { child, lines, told: Vec::new() }
    }

    /// The first new line that is like this.
    fn wait(&mut self, what: &str, like: impl Fn(&str) -> bool) -> String {
        let until = Instant::now() + PATIENCE;
        loop {
            match self.lines.recv_timeout(until.saturating_duration_since(Instant::now())) {
                Ok(line) => {
                    self.told.push(line.clone());
                    if like(&line) {
                        return line;
                    }
                }
                Err(error) => {
                    let _ = self.child.kill();
                    let mut errors = String::new();
                    let _ = self.child.stderr.take().unwrap().read_to_string(&mut errors);
                    let end =
                        if error == RecvTimeoutError::Timeout { "never came" } else { "did not come before the end" };
                    panic!("{what} {end}; told: {:#?}; stderr: {errors}", self.told);
                }
            }
        }
    }

    fn wait_for(&mut self, start: &str) -> String {
        self.wait(start, |line| line.starts_with(start))
    }

    /// The rectangle of `map at X Y, W x H pixels, change N` once N is `change`.
    fn rectangle(&mut self, kind: &str, change: u32) -> [u32; 4] {
        let end = format!("change {change}");
        let line = self
            .wait(&format!("{kind}, {end}"), |line| line.starts_with(&format!("{kind} at ")) && line.ends_with(&end));
        assert!(!line.contains("in part"), "{line}");
        numbers(&line)
    }

    /// Where a control was drawn last.
    fn control(&self, name: &str) -> [u32; 2] {
        let start = format!("control {name} at ");
        let line = self.told.iter().rev().find(|line| line.starts_with(&start));
        numbers(line.unwrap_or_else(|| panic!("{name} is not among {:#?}", self.told)))
    }

    fn lives(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }
}

/// The first whole numbers after the word `at`.
fn numbers<const N: usize>(line: &str) -> [u32; N] {
    let (_, place) = line.split_once(" at ").unwrap();
    let mut words = place.split(|c: char| !c.is_ascii_digit()).filter_map(|word| word.parse().ok());
    std::array::from_fn(|_| words.next().unwrap_or_else(|| panic!("{line}")))
}

/// What the library computes of two files.
fn computed(left: &Path, right: &Path, params: &Params) -> (files::Pair, DisparityMap) {
    let (_, device, queue) = support::device().unwrap();
    let pair = files::read(&[left.into(), right.into()]).unwrap();
    let (width, height) = (pair.left.width(), pair.left.height());
    let matcher = StereoMatcher::new(&device, &queue, width, height, pair.left.format(), params).unwrap();
    let map = matcher.compute_blocking(&pair.left, &pair.right).unwrap().map;
    (pair, map)
}

fn colours(map: &DisparityMap, params: &Params) -> Vec<[u8; 3]> {
    map.color(&params.searched()).chunks_exact(4).map(|rgba| [rgba[0], rgba[1], rgba[2]]).collect()
}

fn corridor() -> [PathBuf; 2] {
    ["left", "right"].map(|side| Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../data/corridor/{side}.png")))
}

/// A folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("viewer-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn the_screen_shows_what_the_library_computes() {
    let Some(screen) = Screen::new() else { return };
    let [left, right] = corridor();
    let [l, r] = [&left, &right].map(|path| path.to_str().unwrap());
    let mut viewer = Viewer::new(&screen, &[l, r, "--disp", "48", "--one-to-one"]);

    // The map, to the bit.
    let mut params = Params::preset(Preset::default(), 48);
    let (pair, map) = computed(&left, &right, &params);
    let place = viewer.rectangle("map", 1);
    assert_eq!(place[2..], [400, 300]);
    let expected = colours(&map, &params);
    assert!(expected.iter().collect::<HashSet<_>>().len() > 200, "the picture has few colours");
    screen.shows(place, &expected, "the map");
    let beside = screen.pixels([place[0] + 1, place[1], place[2], place[3]]);
    assert!(beside != expected, "the same pixels a column farther");

    // The pixel under the pointer.
    for (x, y) in [(200, 150), (130, 230), (5, 20)] {
        screen.point(place[0] + x, place[1] + y);
        let told = viewer.wait_for(&format!("hover x {x}  y {y},"));
        let Some(disparity) = map.get(x, y) else {
            assert!(told.ends_with("no disparity"), "{told}");
            continue;
        };
        let depth = 400.0 * 0.12 / disparity;
        assert!(told.ends_with(&format!("disparity {disparity:.4} px, depth {depth:.3} m")), "{told}");
    }
    assert_eq!((map.get(200, 150).is_some(), map.get(5, 20)), (true, None));

    // A setting, changed in the panel.
    params.adaptive_p2 = false;
    let [x, y] = viewer.control("adaptive-p2");
    screen.click([x + 8, y]);
    let place = viewer.rectangle("map", 2);
    let (_, without) = computed(&left, &right, &params);
    assert!(without != map);
    screen.point(1000, 700); // no note of the pointer over the map
    screen.shows(place, &colours(&without, &params), "the map without adaptive P2");

    // Settings that do not go together: the library's words, and the last map stays.
    let [x, y] = viewer.control("cost");
    screen.click([x + 8, y]);
    viewer.wait_for("control cost=ncc at ");
    let [x, y] = viewer.control("cost=ncc");
    screen.click([x + 8, y]);
    let told = viewer.wait_for("refused ");
    let refused = Params::from_options(48, [("cost", "ncc")]).unwrap_err().to_string();
    assert_eq!(told, format!("refused {refused}"));
    screen.point(1000, 700);
    screen.shows(place, &colours(&without, &params), "the map before");

    // The cloud of points at rest: the left image where there is a disparity, the background where there is none.
    let [x, y] = viewer.control("points");
    screen.click([x + 8, y]);
    let place = viewer.rectangle("points", 2);
    let scale = (place[2] as f32 / 400.0).min(place[3] as f32 / 300.0);
    assert!(scale >= 1.0, "{place:?}");
    let until = Instant::now() + PATIENCE;
    let rest = loop {
        let seen = screen.pixels(place);
        let mut wrong = (0..400 * 300).filter(|i| {
            let (x, y) = (i % 400, i / 400);
            let at = |side: u32, middle: f32, i: u32| (side as f32 / 2.0 + scale * (i as f32 - middle)) as u32;
            let pixel = seen[(at(place[3], 149.5, y) * place[2] + at(place[2], 199.5, x)) as usize];
            let i = *i as usize;
            let point = without.data[i] > 0; // at 0 px it is infinitely far
            let expected = if point { &pair.shown[0][4 * i..4 * i + 3] } else { &[24, 28, 36] };
            pixel != expected
        });
        let Some(first) = wrong.next() else { break seen };
        assert!(Instant::now() < until, "the cloud: {} pixels differ, first {first}", wrong.count() + 1);
        std::thread::sleep(Duration::from_millis(50));
    };

    // Turned by the pointer it is another picture, and not an empty one.
    let middle = [place[0] + place[2] / 2, place[1] + place[3] / 2];
    screen.point(middle[0], middle[1]);
    screen.button(true);
    (1..=5).for_each(|i| screen.point(middle[0] + 20 * i, middle[1] + 4 * i));
    viewer.wait("the turned cloud", |line| line.starts_with("points at ") && line.contains("yaw -0.600, pitch 0.120"));
    screen.button(false);
    let until = Instant::now() + PATIENCE;
    loop {
        let turned = screen.pixels(place);
        let drawn = turned.iter().filter(|pixel| **pixel != [24, 28, 36]).count();
        if turned != rest && drawn > turned.len() / 5 && drawn < turned.len() {
            break;
        }
        assert!(Instant::now() < until, "{drawn} of {} pixels drawn, as at rest: {}", turned.len(), turned == rest);
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(viewer.lives());
}

#[test]
fn drops_are_opened_and_bad_files_told_while_the_window_lives() {
    let Some(screen) = Screen::new() else { return };
    let folder = folder("drops");
    let texture = |x: u32, y: u32, seed: u32| {
        let mut hash = (x / 2).wrapping_mul(0x9e37_79b1) ^ (y / 2 + seed).wrapping_mul(0x85eb_ca6b);
        hash = (hash ^ (hash >> 15)).wrapping_mul(0x2c1b_3c6d);
        (hash >> 13) as u8
    };
    // Pairs, each 5 px apart and of another texture, in two folders.
    let mut pairs = Vec::new();
    for number in 0..3 {
        let sides = [("image_2", 0), ("image_3", 5)].map(|(side, shift)| {
            let path = folder.join(side).join(format!("{number:06}_10.png"));
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            let image = GrayImage::from_fn(90, 60, |x, y| Luma([texture(x + shift, y, 1000 * number)]));
            image.save(&path).unwrap();
            path
        });
        pairs.push(sides);
    }
    let broken = folder.join("broken.png");
    std::fs::write(&broken, &std::fs::read(&pairs[0][0]).unwrap()[..200]).unwrap();
    let other = folder.join("other.png");
    RgbImage::new(20, 10).save(&other).unwrap();

    // A broken file as an argument.
    let [b, r] = [&broken, &pairs[0][1]].map(|path| path.to_str().unwrap());
    let mut viewer = Viewer::new(&screen, &[b, r, "--disp", "16", "--one-to-one"]);
    let told = viewer.wait_for("error ");
    assert!(told.contains("broken.png") && told.contains("is cut short"), "{told}");

    // Two images, the right one first.
    let params = Params::preset(Preset::default(), 16);
    screen.drop_on_window(&[&pairs[0][1], &pairs[0][0]]);
    let place = viewer.rectangle("map", 2);
    let (_, map) = computed(&pairs[0][0], &pairs[0][1], &params);
    assert!(map.data.iter().filter(|&&value| value == 5 * 16).count() > 3000, "{}", map.valid_fraction());
    screen.shows(place, &colours(&map, &params), "the dropped pair");

    // Images of two sizes, and again the broken one: told, and the last map stays.
    screen.drop_on_window(&[&other, &pairs[0][1]]);
    let told = viewer.wait_for("error ");
    assert!(told.contains("20x10") && told.contains("90x60"), "{told}");
    screen.drop_on_window(&[&pairs[0][0], &broken]);
    let told = viewer.wait_for("error ");
    assert!(told.contains("broken.png"), "{told}");
    screen.shows(place, &colours(&map, &params), "the map before");

    // Two folders are a sequence; it plays.
    screen.drop_on_window(&[&folder.join("image_3"), &folder.join("image_2")]);
    viewer.wait_for("pair 1 of 3: ");
    let [x, y] = viewer.control("play");
    screen.click([x + 8, y]);
    for (i, [left, right]) in pairs.iter().enumerate().skip(1) {
        let line = viewer.wait_for(&format!("pair {} of 3: ", i + 1));
        assert!(line.contains(&format!("{left:?} {right:?}")), "{line}");
    }
    viewer.wait_for("pair 1 of 3: ");
    screen.click([x + 8, y]);
    assert!(viewer.lives());
}

#[test]
fn without_a_screen_or_an_adapter_it_ends_with_one_line() {
    let refused = |command: &mut Command, word: &str| {
        let output = command.output().unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), told.lines().count()), (Some(2), 1), "{told}");
        assert!(told.starts_with("error: ") && told.contains(word) && output.stdout.is_empty(), "{told}");
    };
    refused(&mut command("", &[]), "display");
    refused(&mut command(":0", &["one.png"]), "1 paths");
    refused(&mut command(":0", &["--frobnicate"]), "--frobnicate");
    refused(&mut command(":0", &["--tab", "map"]), "must be one of images, points");
    let help = command("", &["--help"]).output().unwrap();
    assert!(ExitStatus::success(&help.status) && String::from_utf8_lossy(&help.stdout).contains("--one-to-one"));
    let Some(screen) = Screen::new() else { return };
    refused(&mut command(&screen.name, &["--disp", "9999"]), "from 1 to 2048");
    let mut none = command(&screen.name, &[]);
    refused(
        none.env("VK_ICD_FILENAMES", "none").env("VK_DRIVER_FILES", "none").env("WGPU_BACKEND", "vulkan"),
        "driver",
    );
}

#[test]
fn the_left_image_is_known_by_its_name() {
    for (left, right) in [
        ("a/left.png", "a/right.png"),
        ("a/Left_01.png", "a/Right_01.png"),
        ("im0.png", "im1.png"),
        ("im2.png", "im6.png"),
        ("view9.png", "view10.png"),
        ("l.png", "r.png"),
        ("cam_l.png", "cam_r.png"),
        ("image_2/000000_10.png", "image_3/000000_10.png"),
        ("left/7.png", "right/7.png"),
    ] {
        let (l, r) = (Path::new(left), Path::new(right));
        assert_eq!(files::in_order(l, r), (l, r));
        assert_eq!(files::in_order(r, l), (l, r));
    }
    // Else as they came.
    for (first, second) in [("b.png", "a.png"), ("tree.png", "house.png"), ("r.png", "leaf.png"), ("a/x", "a/x")] {
        let (first, second) = (Path::new(first), Path::new(second));
        assert_eq!(files::in_order(first, second), (first, second));
    }
}

#[test]
fn a_calibration_gives_depth() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/motorcycle");
    let camera = files::read(&["left.png", "right.png"].map(|name| folder.join(name))).unwrap().camera;
    assert_eq!((camera.focal, camera.doffs, camera.centre), (994.978, 31.086, Some([311.193, 254.877])));
    assert_eq!(camera.depth(50.0), Some(994.978 * 0.193001 / (50.0 + 31.086)));
    assert_eq!((camera.depth(-40.0), files::Camera::default().depth(50.0)), (None, None));
}

/// The sliders go as far as the library lets them, and no farther.
#[test]
fn sliders_have_the_librarys_ranges() {
    for params in Preset::NAMES.iter().map(|(name, _)| Params::from_options(64, [("preset", *name)]).unwrap()) {
        let numbers = Params::OPTIONS.iter().filter(|option| option.values.is_empty());
        for option in numbers {
            let range = panel::range(option, &params).unwrap_or_else(|| panic!("{} has no slider", option.name));
            let accepts = |value: f64| {
                let mut changed = params.clone();
                changed.set(option.name, &value.to_string()).is_ok() && changed.validate().is_ok()
            };
            let beyond = if range.step > 0.0 { range.step } else { 0.05 };
            assert!(
                (range.least < range.most || option.name == "passes") && accepts(range.least) && accepts(range.most),
                "{} {range:?}",
                option.name
            );
            assert!(!accepts(range.least - beyond), "{} {range:?}", option.name);
            assert!(!accepts(range.most + beyond) || range.most > 1e9, "{} {range:?}", option.name);
        }
        let range =
            |name: &str| panel::range(Params::OPTIONS.iter().find(|option| option.name == name).unwrap(), &params);
        let of = |least, most, step| Some(panel::Range { least, most, step });
        assert_eq!(range("p2"), of(params.p1.into(), 127.0, 1.0));
        assert_eq!(range("block"), of(1.0, 51.0, 2.0));
        assert_eq!((range("wls-sigma"), range("cost")), (of(0.1, 1000.0, 0.0), None));
    }
}
