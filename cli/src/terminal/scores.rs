//! Scores as `--json` and the tables print them.

use super::table::table;
use gpu_stereo::evaluation::Scores;
use serde::Serialize;

/// Scores as `--json` prints them: shares from 0 to 1, errors in px, null where no pixel is valid.
#[derive(Clone, Debug, Serialize)]
pub struct Evaluation {
    pixels: u64,
    pub density: f64,
    bad_0_5: f64,
    pub bad_1: f64,
    pub bad_2: f64,
    bad_4: f64,
    bad_0_5_of_valid: Option<f64>,
    bad_1_of_valid: Option<f64>,
    pub bad_2_of_valid: Option<f64>,
    bad_4_of_valid: Option<f64>,
    pub average_error: Option<f64>,
    rms_error: Option<f64>,
    a50: Option<f64>,
    a90: Option<f64>,
    pub a95: Option<f64>,
    a99: Option<f64>,
    pub d1_est: Option<f64>,
    pub d1_all: f64,
}

impl From<&Scores> for Evaluation {
    fn from(scores: &Scores) -> Self {
        let [bad_0_5, bad_1, bad_2, bad_4] = [0, 1, 2, 3].map(|i| scores.bad(i));
        let [bad_0_5_of_valid, bad_1_of_valid, bad_2_of_valid, bad_4_of_valid] =
            [0, 1, 2, 3].map(|i| scores.bad_of_valid(i));
        let [a50, a90, a95, a99] = [0, 1, 2, 3].map(|i| scores.quantiles.map(|errors| errors[i]));
        Self {
            pixels: scores.pixels,
            density: scores.density(),
            bad_0_5,
            bad_1,
            bad_2,
            bad_4,
            bad_0_5_of_valid,
            bad_1_of_valid,
            bad_2_of_valid,
            bad_4_of_valid,
            average_error: scores.average(),
            rms_error: scores.rms(),
            a50,
            a90,
            a95,
            a99,
            d1_est: scores.d1_est(),
            d1_all: scores.d1_all(),
        }
    }
}

/// A share in per cent, or a dash.
pub fn percent(share: impl Into<Option<f64>>) -> String {
    share.into().map_or("-".into(), |share| format!("{:.2} %", 100.0 * share))
}

/// An error in px, or a dash.
pub fn pixels(error: Option<f64>) -> String {
    error.map_or("-".into(), |error| format!("{error:.3} px"))
}

impl Evaluation {
    /// The mean of each figure over several maps, of those where it is known, and the sum of their pixels.
    pub fn mean(of: &[Self]) -> Self {
        let mean = |figure: fn(&Self) -> Option<f64>| {
            let known: Vec<_> = of.iter().filter_map(figure).collect();
            (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
        };
        let share = |figure: fn(&Self) -> f64| of.iter().map(figure).sum::<f64>() / of.len() as f64;
        Self {
            pixels: of.iter().map(|e| e.pixels).sum(),
            density: share(|e| e.density),
            bad_0_5: share(|e| e.bad_0_5),
            bad_1: share(|e| e.bad_1),
            bad_2: share(|e| e.bad_2),
            bad_4: share(|e| e.bad_4),
            bad_0_5_of_valid: mean(|e| e.bad_0_5_of_valid),
            bad_1_of_valid: mean(|e| e.bad_1_of_valid),
            bad_2_of_valid: mean(|e| e.bad_2_of_valid),
            bad_4_of_valid: mean(|e| e.bad_4_of_valid),
            average_error: mean(|e| e.average_error),
            rms_error: mean(|e| e.rms_error),
            a50: mean(|e| e.a50),
            a90: mean(|e| e.a90),
            a95: mean(|e| e.a95),
            a99: mean(|e| e.a99),
            d1_est: mean(|e| e.d1_est),
            d1_all: share(|e| e.d1_all),
        }
    }

    /// The table on stdout.
    pub fn table(&self) -> String {
        let both = |name: &str, all: f64, valid: Option<f64>| [name.to_owned(), percent(all), percent(valid)];
        let of_valid = |name: &str, error: Option<f64>| [name.to_owned(), String::new(), pixels(error)];
        let rows = [
            ["density".into(), percent(self.density), String::new()],
            both("bad-0.5", self.bad_0_5, self.bad_0_5_of_valid),
            both("bad-1", self.bad_1, self.bad_1_of_valid),
            both("bad-2", self.bad_2, self.bad_2_of_valid),
            both("bad-4", self.bad_4, self.bad_4_of_valid),
            both("D1", self.d1_all, self.d1_est),
            of_valid("average error", self.average_error),
            of_valid("RMS error", self.rms_error),
            of_valid("A50", self.a50),
            of_valid("A90", self.a90),
            of_valid("A95", self.a95),
            of_valid("A99", self.a99),
        ];
        let all = format!("of {} pixels", self.pixels);
        table(["", &all, "of those valid"], rows, 1..3)
    }
}
