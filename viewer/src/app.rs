//! What the window shows, and what it does with the pointer and with dropped files.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use egui::{Align2, Color32, FontId, Pos2, Rect, Response, RichText, Sense, Stroke, Ui, Vec2, pos2, vec2};
use egui_wgpu::Renderer;
use gpu_stereo::{turbo, wgpu};

use crate::files::{self, Camera, Paths};
use crate::live::{Live, Wanted};
use crate::options::{Options, Tab};
use crate::panel::Settings;
use crate::points::{Orbit, Points, Scene};

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

    /// The map twice as large as the pair, beside or above it, whichever is larger.
    fn images(&mut self, ui: &mut Ui) {
        let (Some(shown), Some(ids)) = (&self.live.shown, &self.ids) else { return };
        let (left, right, colours) = (ids.left, ids.right, ids.colours);
        let searched = shown.wanted.params.searched();
        let size = vec2(shown.matched.map.width as f32, shown.matched.map.height as f32);
        let per_point = ui.ctx().pixels_per_point();
        let (gap, caption) = (6.0, 18.0);
        let room = ui.available_size() - vec2(gap, 2.0 * caption + gap);
        let beside = (room.x / (3.0 * size.x)).min(room.y / (2.0 * size.y));
        let above = (room.x / (2.0 * size.x)).min(room.y / (3.0 * size.y));
        let scale = if self.one_to_one { 0.5 / per_point } else { beside.max(above).max(0.01) };
        let (small, large) = (size * scale, size * 2.0 * scale);
        let step = vec2(gap, gap + caption);
        let (offsets, whole) = if beside >= above {
            let x = large.x + gap;
            ([vec2(x, 0.0), vec2(x, small.y + step.y)], vec2(x + small.x, large.y + step.y + caption))
        } else {
            let y = large.y + step.y;
            ([vec2(0.0, y), vec2(small.x + gap, y)], vec2(large.x + gap, y + small.y + caption))
        };
        egui::ScrollArea::both().auto_shrink(false).show(ui, |ui| {
            let (area, _) = ui.allocate_exact_size(whole, Sense::hover());
            // On whole pixels of the screen, so that 1:1 is exact.
            let place = |offset: Vec2, size: Vec2| {
                let min = area.min + offset + vec2(0.0, caption);
                Rect::from_min_size((min.to_vec2() * per_point).round().to_pos2() / per_point, size)
            };
            let rects = [place(Vec2::ZERO, large), place(offsets[0], small), place(offsets[1], small)];
            let [map, ..] = rects;
            let mut responses = Vec::new();
            for ((rect, id), name) in rects.into_iter().zip([colours, left, right]).zip(["disparity", "left", "right"])
            {
                let at = rect.left_top() - vec2(0.0, 2.0);
                ui.painter().text(at, Align2::LEFT_BOTTOM, name, FontId::proportional(13.0), ui.visuals().text_color());
                ui.painter().image(id, rect, Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0)), Color32::WHITE);
                responses.push(ui.interact(rect, ui.scope_id().with(name), Sense::hover()));
            }
            legend(ui, map, searched);
            let changes = self.live.changes;
            let seen = ui.clip_rect().expand(0.5).contains_rect(map);
            self.trace(|| {
                let at = map.min.to_vec2() * per_point;
                let whole = if seen { "" } else { " in part" };
                format!(
                    "map at {} {}, {} x {} pixels{whole}, change {changes}",
                    at.x,
                    at.y,
                    map.width() * per_point,
                    map.height() * per_point
                )
            });
            // The map and the left image tell of the same pixels.
            for (response, rect) in responses.into_iter().zip(rects).take(2) {
                self.hover(ui, response, rect, &rects);
            }
        });
    }

    /// What the pixel under the pointer has, and where it is in all pictures.
    fn hover(&mut self, ui: &Ui, response: Response, rect: Rect, rects: &[Rect; 3]) {
        let (Some(pointer), Some(shown)) = (response.hover_pos(), &self.live.shown) else { return };
        let map = &shown.matched.map;
        let size = vec2(map.width as f32, map.height as f32);
        let at = (pointer - rect.min) / rect.size() * size;
        let (x, y) = (at.x as u32, at.y as u32);
        let disparity = map.get(x, y);
        let mut text = format!("x {x}  y {y}\n");
        text += &disparity.map_or("no disparity".into(), |d| format!("disparity {d:.4} px"));
        let depth = disparity.and_then(|d| self.camera.depth(d));
        text += &match (disparity, depth) {
            (Some(_), Some(depth)) => format!("\ndepth {depth:.3} m"),
            (Some(_), None) => "\ndepth unknown: give focal length and baseline".into(),
            (None, _) => String::new(),
        };
        let index = y as usize * map.width as usize + x as usize;
        let confidence = shown.matched.confidence.as_ref().and_then(|map| map.data.get(index));
        if let Some(confidence) = confidence.filter(|_| disparity.is_some()) {
            text += &format!("\nconfidence {confidence} of 255");
        }
        self.trace(|| format!("hover {}", text.replace('\n', ", ")));
        let centre = vec2(x as f32 + 0.5, y as f32 + 0.5);
        let shifts = [Some(0.0), Some(0.0), disparity];
        for (rect, shift) in rects.iter().zip(shifts).filter(|(other, _)| **other != rect) {
            if let Some(shift) = shift {
                let at = rect.min + (centre - vec2(shift, 0.0)) / size * rect.size();
                ui.painter().circle_stroke(at, 6.0, Stroke::new(3.0, Color32::BLACK));
                ui.painter().circle_stroke(at, 6.0, Stroke::new(1.5, Color32::WHITE));
            }
        }
        response.on_hover_ui_at_pointer(|ui| {
            ui.monospace(text);
        });
    }

    fn cloud(&mut self, ui: &mut Ui, renderer: &mut Renderer) {
        let (Some(shown), Some(textures)) = (&self.live.shown, &self.live.textures) else { return };
        let per_point = ui.ctx().pixels_per_point();
        let room = ui.available_rect_before_wrap();
        let min = (room.min.to_vec2() * per_point).ceil().to_pos2();
        // Even sides: the middle lies between pixels.
        let picture =
            <[f32; 2]>::from(room.size() * per_point - Vec2::splat(1.0)).map(|side| (side as u32 / 2).max(1) * 2);
        let rect = Rect::from_min_size(min, vec2(picture[0] as f32, picture[1] as f32)) / per_point;
        let response = ui.interact(rect, ui.scope_id().with("cloud"), Sense::drag());
        let wheel = if response.hovered() { ui.input(|input| input.smooth_scroll_delta().y) } else { 0.0 };
        self.orbit = self.orbit.nearer(wheel);
        if response.drag_started() {
            self.grabbed = self.orbit;
        }
        let from = ui.input(|input| input.pointer.press_origin());
        if response.dragged()
            && let (Some(from), Some(to)) = (from, response.interact_pointer_pos())
        {
            self.orbit = Orbit { distance: self.orbit.distance, ..self.grabbed.turned((to - from).into()) };
        }
        let map = [shown.matched.map.width, shown.matched.map.height];
        let scene = Scene {
            orbit: self.orbit,
            camera: self.camera,
            size: self.point_size,
            middle: self.middle,
            map,
            picture,
            changes: self.live.changes,
        };
        let (view, new) = self.points.draw(&self.device, &self.queue, textures, scene);
        if new && let Some(id) = self.points_id.take() {
            renderer.free_texture(&id);
        }
        let id = *self
            .points_id
            .get_or_insert_with(|| renderer.register_native_texture(&self.device, view, wgpu::FilterMode::Nearest));
        ui.painter().image(id, rect, Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0)), Color32::WHITE);
        let (changes, orbit) = (self.live.changes, self.orbit);
        self.trace(|| {
            format!(
                "points at {} {}, {} x {} pixels, yaw {:.3}, pitch {:.3}, distance {:.3}, change {changes}",
                min.x, min.y, picture[0], picture[1], orbit.yaw, orbit.pitch, orbit.distance
            )
        });
    }
}

/// What the colours mean, above the right end of the map.
fn legend(ui: &Ui, map: Rect, searched: RangeInclusive<i32>) {
    const BAR: u8 = 96;
    let (font, ink) = (FontId::proportional(13.0), ui.visuals().text_color());
    let most = map.right_top() - vec2(0.0, 2.0);
    let most = ui.painter().text(most, Align2::RIGHT_BOTTOM, format!("{} px", searched.end()), font.clone(), ink);
    let bar = Rect::from_min_size(most.left_top() - vec2(f32::from(BAR) + 6.0, -4.0), vec2(f32::from(BAR), 9.0));
    for i in 0..BAR {
        let [r, g, b] = turbo(f64::from(i) / f64::from(BAR - 1));
        let line = Rect::from_min_size(bar.min + vec2(i.into(), 0.0), vec2(1.0, bar.height()));
        ui.painter().rect_filled(line, 0.0, Color32::from_rgb(r, g, b));
    }
    ui.painter().text(pos2(bar.left() - 6.0, most.top()), Align2::RIGHT_TOP, searched.start(), font, ink);
}
