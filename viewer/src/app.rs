//! What the window shows, and what it does with the pointer and with dropped files.

mod pictures;

use std::path::PathBuf;

use egui::{Align2, Color32, FontId, Rect, RichText, Ui};
use egui_wgpu::Renderer;
use gpu_stereo::wgpu;

use crate::files::{self, Camera, Paths};
use crate::live::{Live, Wanted};
use crate::options::{Options, Tab};
use crate::panel::Settings;
use crate::points::{Orbit, Points};

/// The ids under which egui draws the textures, and of which change of `Live` they are.
struct Ids {
    left: egui::TextureId,
    right: egui::TextureId,
    colours: egui::TextureId,
    of: wgpu::TextureView,
}

pub struct App {
    device: wgpu::Device,
    queue: wgpu::Queue,
    adapter: String,
    live: Live,
    settings: Settings,
    /// The pairs of a sequence, or the one pair.
    pairs: Vec<Paths>,
    at: usize,
    playing: bool,
    /// The first of two files that were dropped one after the other.
    first: Option<PathBuf>,
    /// Why what was dropped or given is not taken.
    refused: Option<String>,
    camera: Camera,
    /// The pair whose calibration is in `camera`.
    camera_of: Option<Paths>,
    tab: Tab,
    one_to_one: bool,
    ids: Option<Ids>,
    points: Points,
    points_id: Option<egui::TextureId>,
    orbit: Orbit,
    /// As it was when the pointer took hold of the cloud.
    grabbed: Orbit,
    point_size: f32,
    middle: f32,
    seen: u64,
    trace: Option<Trace>,
}

/// What is told on stdout with `--trace`.
#[derive(Default)]
struct Trace {
    now: Vec<String>,
    told: Vec<String>,
}

impl App {
    pub fn new(options: Options, device: &wgpu::Device, queue: &wgpu::Queue, adapter: String) -> Result<Self, String> {
        let mut app = Self {
            device: device.clone(),
            queue: queue.clone(),
            adapter,
            live: Live::new(device, queue),
            settings: Settings::new(&options.disparities)?,
            pairs: Vec::new(),
            at: 0,
            playing: false,
            first: None,
            refused: None,
            camera: Camera::default(),
            camera_of: None,
            tab: options.tab,
            one_to_one: options.one_to_one,
            ids: None,
            points: Points::new(device),
            points_id: None,
            orbit: Orbit::REST,
            grabbed: Orbit::REST,
            point_size: 1.0,
            middle: 0.0,
            seen: 0,
            trace: options.trace.then(Trace::default),
        };
        if let Some([left, right]) = options.pair {
            app.open(left, right);
        }
        Ok(app)
    }

    fn open(&mut self, first: PathBuf, second: PathBuf) {
        match files::pairs(&first, &second) {
            Ok(pairs) => (self.pairs, self.at, self.playing, self.refused) = (pairs, 0, false, None),
            Err(error) => self.refuse(error),
        }
    }

    fn refuse(&mut self, error: String) {
        eprintln!("error: {error}");
        self.refused = Some(error);
    }

    /// Takes what was dropped: two at once, or one and then the other.
    fn drop_files(&mut self, dropped: Vec<PathBuf>) {
        let mut all: Vec<PathBuf> = self.first.take().into_iter().chain(dropped).collect();
        match (all.pop(), all.pop(), all.len()) {
            (Some(only), None, _) => (self.first, self.refused) = (Some(only), None),
            (Some(second), Some(first), 0) => self.open(first, second),
            (_, _, more) => self.refuse(format!("{} files were dropped; drop two files or two folders", more + 2)),
        }
    }

    /// Goes on with what is under way. Whether there is something.
    pub fn advance(&mut self) -> bool {
        let wanted =
            self.pairs.get(self.at).map(|paths| Wanted { paths: paths.clone(), params: self.settings.params.clone() });
        let new = self.live.advance(wanted.as_ref());
        if new {
            self.take_shown();
        }
        if self.playing && self.pairs.len() > 1 && self.live.doing().is_none() {
            self.at = (self.at + 1) % self.pairs.len();
        }
        let shown = self.live.shown.as_ref().map(|shown| &shown.wanted);
        self.live.doing().is_some() || (wanted.as_ref() != shown && self.live.error.is_none()) || self.playing
    }

    /// Whether there is something to show that has not been drawn yet.
    pub fn changed(&self) -> bool {
        self.seen != self.live.changes
    }

    /// The calibration and the middle of a map that is new.
    fn take_shown(&mut self) {
        let Some(shown) = &self.live.shown else { return };
        if self.camera_of.as_ref() != Some(&shown.wanted.paths) {
            self.camera_of = Some(shown.wanted.paths.clone());
            if shown.pair.camera != Camera::default() {
                self.camera = shown.pair.camera;
            }
        }
        let invalid = gpu_stereo::DisparityMap::INVALID;
        let mut valid: Vec<i16> = shown.matched.map.data.iter().copied().filter(|&value| value != invalid).collect();
        let half = valid.len() / 2;
        if !valid.is_empty() {
            self.middle = f32::from(*valid.select_nth_unstable(half).1) / 16.0;
        }
    }

    /// Tells what can be seen now, if it was asked for.
    pub fn presented(&mut self) {
        let Some(trace) = &mut self.trace else { return };
        if trace.now != trace.told {
            trace.now.iter().filter(|line| !trace.told.contains(line)).for_each(|line| println!("{line}"));
            trace.told = trace.now.clone();
        }
        trace.now.clear();
    }

    fn trace(&mut self, line: impl FnOnce() -> String) {
        if let Some(trace) = &mut self.trace {
            trace.now.push(line());
        }
    }

    /// Tells where a control is.
    fn place(&mut self, ui: &Ui, name: &str, rect: Rect) {
        let at = rect.left_center() * ui.ctx().pixels_per_point();
        self.trace(|| format!("control {name} at {} {}", at.x.round(), at.y.round()));
    }

    pub fn ui(&mut self, ui: &mut Ui, renderer: &mut Renderer) {
        self.seen = self.live.changes;
        if let Some(trace) = &mut self.trace {
            trace.now.clear(); // egui may ask twice for one frame
        }
        let dropped: Vec<_> =
            ui.input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect());
        if !dropped.is_empty() {
            self.drop_files(dropped);
        }
        self.register(renderer);
        egui::Panel::top("top").show(ui, |ui| self.top(ui));
        egui::Panel::bottom("bottom").show(ui, |ui| self.bottom(ui));
        egui::Panel::left("settings").resizable(true).default_size(340.0).show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                self.camera_ui(ui);
                ui.separator();
                self.settings.ui(ui);
            });
        });
        for (name, rect) in std::mem::take(&mut self.settings.places) {
            self.place(ui, &name, rect);
        }
        egui::CentralPanel::default().show(ui, |ui| match self.tab {
            _ if self.live.shown.is_none() => self.hint(ui),
            Tab::Images => self.images(ui),
            Tab::Points => self.cloud(ui, renderer),
        });
        if ui.input(|input| !input.raw.hovered_files.is_empty()) {
            let rect = ui.ctx().content_rect();
            let painter = ui.ctx().layer_painter(egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop")));
            painter.rect_filled(rect, 0.0, Color32::from_black_alpha(160));
            painter.text(
                rect.center(),
                Align2::CENTER_CENTER,
                "drop two images, or two folders",
                FontId::proportional(24.0),
                Color32::WHITE,
            );
        }
    }

    /// Hands textures to egui that it does not know yet.
    fn register(&mut self, renderer: &mut Renderer) {
        let Some(textures) = &self.live.textures else { return };
        if self.ids.as_ref().is_some_and(|ids| ids.of == textures.left) {
            return;
        }
        if let Some(ids) = self.ids.take() {
            [ids.left, ids.right, ids.colours].iter().for_each(|id| renderer.free_texture(id));
        }
        let mut id = |view, filter| renderer.register_native_texture(&self.device, view, filter);
        self.ids = Some(Ids {
            left: id(&textures.left, wgpu::FilterMode::Linear),
            right: id(&textures.right, wgpu::FilterMode::Linear),
            colours: id(&textures.colours, wgpu::FilterMode::Nearest),
            of: textures.left.clone(),
        });
    }

    fn top(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            ui.selectable_value(&mut self.tab, Tab::Images, "Images");
            let points = ui.selectable_value(&mut self.tab, Tab::Points, "Points");
            self.place(ui, "points", points.rect);
            ui.separator();
            match self.tab {
                Tab::Images => {
                    ui.checkbox(&mut self.one_to_one, "1:1")
                        .on_hover_text("a pixel of the screen for each pixel of the map");
                }
                Tab::Points => {
                    if ui.button("at rest").on_hover_text("as the left camera saw it").clicked() {
                        self.orbit = Orbit::REST;
                    }
                    ui.add(egui::Slider::new(&mut self.point_size, 1.0..=6.0).text("point size"));
                    ui.weak("drag to turn, wheel to go nearer");
                }
            }
            if self.pairs.len() > 1 {
                ui.separator();
                let last = self.pairs.len() - 1;
                if ui.button("<").on_hover_text("the pair before").clicked() {
                    (self.at, self.playing) = (self.at.checked_sub(1).unwrap_or(last), false);
                }
                let play = ui.button(if self.playing { "pause" } else { "play" });
                self.place(ui, "play", play.rect);
                if play.clicked() {
                    self.playing = !self.playing;
                }
                if ui.button(">").on_hover_text("the next pair").clicked() {
                    (self.at, self.playing) = (if self.at == last { 0 } else { self.at + 1 }, false);
                }
                ui.label(format!("pair {} of {}", self.at + 1, self.pairs.len()));
            }
            if let Some([left, right]) = self.pairs.get(self.at).cloned() {
                let (number, of) = (self.at + 1, self.pairs.len());
                self.trace(|| format!("pair {number} of {of}: {left:?} {right:?}"));
                ui.separator();
                let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let both = format!("{} | {}", name(&left), name(&right));
                ui.weak(both).on_hover_text(format!("{}\n{}", left.display(), right.display()));
            }
        });
    }

    fn bottom(&mut self, ui: &mut Ui) {
        let red = ui.visuals().error_fg_color;
        for error in [self.refused.clone(), self.live.error.clone()].into_iter().flatten() {
            ui.colored_label(red, &error);
            self.trace(|| format!("error {error}"));
        }
        if let Some(error) = self.settings.error.clone() {
            self.trace(|| format!("refused {error}"));
        }
        if let Some(first) = &self.first {
            ui.label(format!("{} is one image: drop the other one, too", first.display()));
        }
        ui.horizontal_wrapped(|ui| {
            ui.label(&self.adapter);
            if let Some(shown) = &self.live.shown {
                let map = &shown.matched.map;
                ui.separator();
                ui.label(format!("{} x {}, {:.1} % valid", map.width, map.height, 100.0 * map.valid_fraction()));
                ui.separator();
                ui.label(format!("frame {:.1} ms", shown.frame_ms)).on_hover_text("upload, kernels, readback");
                ui.separator();
                ui.label(format!("settings {:.0} ms", shown.prepare_ms))
                    .on_hover_text("kernels that are new are compiled");
            }
            if let Some(doing) = self.live.doing() {
                ui.separator();
                ui.label(format!("{doing} ..."));
            }
        });
        ui.horizontal_wrapped(|ui| ui.monospace(RichText::new(self.settings.command()).weak()));
    }

    fn camera_ui(&mut self, ui: &mut Ui) {
        egui::Grid::new("camera").num_columns(2).spacing([8.0, 4.0]).show(ui, |ui| {
            let Camera { focal, baseline, doffs, .. } = &mut self.camera;
            for (name, value, speed, unit, help) in [
                ("focal length", focal, 1.0, " px", "of the rectified cameras; 0: not known"),
                ("baseline", baseline, 0.001, " m", "between the cameras; 0: not known"),
                ("doffs", doffs, 0.1, " px", "difference of the principal points, right less left"),
            ] {
                ui.label(name).on_hover_text(help);
                let range = if name == "doffs" { -4096.0..=4096.0 } else { 0.0..=1e6 };
                ui.add(egui::DragValue::new(value).speed(speed).range(range).max_decimals(4).suffix(unit));
                ui.end_row();
            }
        });
    }

    fn hint(&self, ui: &mut Ui) {
        let text = match self.live.doing() {
            Some(doing) => format!("{doing} ..."),
            None => "Drop two images of a rectified pair here, or two folders".into(),
        };
        ui.centered_and_justified(|ui| ui.label(RichText::new(text).size(20.0)));
    }
}
