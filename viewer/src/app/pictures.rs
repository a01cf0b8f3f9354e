//! The pictures of the window: the pair beside its map, what is under the pointer, the cloud.

use std::ops::RangeInclusive;

use egui::{Align2, Color32, FontId, Pos2, Rect, Response, Sense, Stroke, Ui, Vec2, pos2, vec2};
use egui_wgpu::Renderer;
use gpu_stereo::{turbo, wgpu};

use super::App;
use crate::points::{Orbit, Scene};

impl App {
    /// The map twice as large as the pair, beside or above it, whichever is larger.
    pub(super) fn images(&mut self, ui: &mut Ui) {
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

    pub(super) fn cloud(&mut self, ui: &mut Ui, renderer: &mut Renderer) {
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
