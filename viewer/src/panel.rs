//! The settings, made from the library's own table: a setting that is added there is here, too.

use std::collections::BTreeMap;

use egui::{Checkbox, ComboBox, RichText, Slider, Ui};
use gpu_stereo::{ParamOption, Params, Preset};

/// A preset, and what differs from it, as on the command line.
pub struct Settings {
    preset: String,
    changed: BTreeMap<&'static str, String>,
    /// The last settings that go together.
    pub params: Params,
    /// Why those that are chosen now do not.
    pub error: Option<String>,
    ranges: BTreeMap<&'static str, Range>,
    /// Where the controls were drawn.
    pub places: Places,
}

/// The numbers that a setting takes beside the others as they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    pub least: f64,
    pub most: f64,
    /// 0 for fractions.
    pub step: f64,
}

/// Controls and their choices by name, and where they are.
type Places = Vec<(String, egui::Rect)>;

const PRESET: &str = "balanced";

impl Settings {
    /// The default preset over so many disparities.
    pub fn new(disparities: &str) -> Result<Self, String> {
        let mut settings = Self {
            preset: PRESET.into(),
            changed: BTreeMap::from([("disp", disparities.into())]),
            params: Params::preset(Preset::default(), 64),
            error: None,
            ranges: BTreeMap::new(),
            places: Vec::new(),
        };
        settings.take();
        settings.error.take().map_or(Ok(settings), Err)
    }

    /// Judges what is chosen.
    fn take(&mut self) {
        let changed = self.changed.iter().map(|(name, value)| (*name, value.as_str()));
        let confidence = self.params.confidence;
        match Params::from_options(64, changed.chain([("preset", self.preset.as_str())])) {
            Ok(params) => {
                self.params = params;
                self.params.confidence = confidence;
                self.error = None;
                self.ranges = Params::OPTIONS.iter().filter_map(|o| Some((o.name, range(o, &self.params)?))).collect();
            }
            Err(error) => self.error = Some(error.to_string()),
        }
    }

    /// As the command would be called.
    pub fn command(&self) -> String {
        let preset = if self.preset == PRESET { String::new() } else { format!(" --preset {}", self.preset) };
        let changed: String = self.changed.iter().map(|(name, value)| format!(" --{name} {value}")).collect();
        format!("gpu-stereo LEFT RIGHT{preset}{changed}")
    }

    pub fn ui(&mut self, ui: &mut Ui) {
        let before = (self.preset.clone(), self.changed.clone());
        self.places.clear();
        ui.horizontal(|ui| {
            ui.label("preset");
            words(ui, "preset", Preset::NAMES, &mut self.preset, &mut self.places);
            if ui.button("reset").on_hover_text("the preset as it is, over the same disparities").clicked() {
                self.preset = before.0.clone();
                self.changed.retain(|name, _| matches!(*name, "disp" | "min-disp"));
            }
        });
        if self.preset != before.0 {
            self.changed.retain(|name, _| matches!(*name, "disp" | "min-disp"));
        }
        ui.checkbox(&mut self.params.confidence, "confidence")
            .on_hover_text("compute it, too, for the pixel under the pointer");
        if let Some(error) = &self.error {
            ui.colored_label(ui.visuals().error_fg_color, error);
        }
        for options in Params::OPTIONS.chunk_by(|a, b| a.heading == b.heading) {
            let Some(heading) = options.first().map(|option| option.heading) else { continue };
            egui::CollapsingHeader::new(RichText::new(heading).strong()).default_open(heading != "Device").show(
                ui,
                |ui| {
                    egui::Grid::new(heading).num_columns(2).min_col_width(120.0).spacing([8.0, 4.0]).show(ui, |ui| {
                        for option in options {
                            self.row(ui, option);
                            ui.end_row();
                        }
                    });
                },
            );
        }
        if (&self.preset, &self.changed) != (&before.0, &before.1) {
            self.take();
        }
    }

    fn row(&mut self, ui: &mut Ui, option: &'static ParamOption) {
        let value = self.changed.get(option.name).cloned().unwrap_or_else(|| option.get(&self.params));
        let mut text = RichText::new(option.name);
        if self.changed.contains_key(option.name) {
            text = text.strong();
        }
        let label = ui.add(egui::Label::new(text).sense(egui::Sense::click()));
        if label.on_hover_text(format!("{}\nclick: as the preset has it", option.help)).clicked()
            && option.name != "disp"
        {
            self.changed.remove(option.name);
            return;
        }
        let idle = option
            .idle(&self.params)
            .map(|other| format!("changes nothing beside {} {}", other.name, other.get(&self.params)));
        let mut chosen = value.clone();
        let range = self.ranges.get(option.name).copied();
        let shown = ui.add_enabled_ui(idle.is_none(), |ui| control(ui, option, range, &mut chosen, &mut self.places));
        self.places.push((option.name.into(), shown.response.rect));
        if let Some(idle) = idle {
            shown.response.on_disabled_hover_text(idle);
        }
        if chosen != value {
            self.changed.insert(option.name, chosen);
        }
    }
}

/// A check box, a list or a slider, by what the option takes.
fn control(ui: &mut Ui, option: &ParamOption, range: Option<Range>, value: &mut String, places: &mut Places) {
    if let [("on", _), ("off", _)] = option.values {
        let mut on = value == "on";
        ui.add(Checkbox::without_text(&mut on));
        *value = if on { "on" } else { "off" }.into();
        return;
    }
    if !option.values.is_empty() {
        return words(ui, option.name, option.values, value, places);
    }
    let Some(range) = range else {
        ui.text_edit_singleline(value);
        return;
    };
    ui.horizontal(|ui| {
        if option.placeholder.ends_with("off") {
            let (mut on, was) = (value != "off", value != "off");
            ui.add(Checkbox::without_text(&mut on));
            match (was, on) {
                (true, false) => *value = "off".into(),
                (false, true) => *value = usual(option, range),
                _ => {}
            }
        }
        let Ok(before) = value.parse::<f64>() else { return };
        let mut number = before;
        let slider = Slider::new(&mut number, range.least..=range.most).logarithmic(range.most - range.least > 300.0);
        let slider =
            if range.step > 0.0 { slider.step_by(range.step).fixed_decimals(0) } else { slider.max_decimals(2) };
        ui.add(slider);
        if number != before {
            *value = number.to_string();
        }
    });
}

fn words(ui: &mut Ui, name: &str, words: &[(&str, &str)], value: &mut String, places: &mut Places) {
    ComboBox::from_id_salt(name).selected_text(value.as_str()).width(110.0).height(400.0).show_ui(ui, |ui| {
        for (word, help) in words {
            let choice = ui.selectable_label(value == word, *word);
            let choice = if help.is_empty() { choice } else { choice.on_hover_text(*help) };
            places.push((format!("{name}={word}"), choice.rect));
            if choice.clicked() {
                *value = (*word).into();
            }
        }
    });
}

/// What a setting is switched on with: what some preset has, else little.
fn usual(option: &ParamOption, range: Range) -> String {
    let presets = Preset::NAMES.iter().filter_map(|(name, _)| Params::from_options(64, [("preset", *name)]).ok());
    presets.map(|params| option.get(&params)).find(|value| value != "off").unwrap_or((range.least + 1.0).to_string())
}

/// The numbers that a setting takes: the library is asked, so that ranges that depend on other settings are right.
/// Nothing for a setting that takes words.
pub fn range(option: &ParamOption, params: &Params) -> Option<Range> {
    if !option.values.is_empty() {
        return None;
    }
    let accepts = |value: f64| {
        let mut changed = params.clone();
        changed.set(option.name, &value.to_string()).is_ok() && changed.validate().is_ok()
    };
    let fractions = params.clone().set(option.name, "0.5").is_ok();
    let current = option.get(params).parse::<f64>().ok();
    let start = current.into_iter().chain([1.0, 3.0, 9.0, 0.0]).find(|&value| accepts(value))?;
    if fractions {
        let edge = |from: f64, to: f64| {
            let (mut good, mut bad) = (from, to);
            for _ in 0..60 {
                let middle = (good + bad) / 2.0;
                *(if accepts(middle) { &mut good } else { &mut bad }) = middle;
            }
            // The library's limits are decimal numbers.
            let near = (good * 100.0).round() / 100.0;
            if accepts(near) { near } else { good }
        };
        let least = if accepts(0.0) { 0.0 } else { edge(start, 0.0) };
        return Some(Range { least, most: edge(start, 1e9), step: 0.0 });
    }
    // Some take odd numbers only.
    let either = |step: f64| accepts(start + step) || accepts(start - step);
    let step = if !either(1.0) && either(2.0) { 2.0 } else { 1.0 };
    let edge = |sign: f64| {
        let at = |steps: u64| start + sign * step * steps as f64;
        let mut stride = 1;
        while stride < 1 << 33 && accepts(at(stride)) {
            stride *= 2;
        }
        let (mut good, mut bad) = (stride / 2, stride);
        while bad - good > 1 {
            let middle = (good + bad) / 2;
            *(if accepts(at(middle)) { &mut good } else { &mut bad }) = middle;
        }
        at(good)
    };
    Some(Range { least: edge(-1.0), most: edge(1.0), step })
}
