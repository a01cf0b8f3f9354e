//! What surfaces look like.

use super::chance::Chance;
use crate::caster::{V, dot, hash, value_noise};

/// What divides a surface into its two colours.
#[derive(Clone, Copy)]
enum Pattern {
    Plain,
    Clouds,
    Checks,
    Bricks,
    Stripes,
    Spots,
    Panes,
}

/// The look of a surface.
#[derive(Clone)]
pub struct Material {
    pattern: Pattern,
    colours: [V; 2],
    /// The directions along which the pattern lies.
    frame: [V; 3],
    /// The length of a period of the pattern, in metres.
    cell: f64,
    /// How strong the noise is, the period of its coarsest octave, and how much weaker the next octave is.
    noise: [f64; 3],
    /// How strong a highlight is.
    pub gloss: f64,
    /// How much of its surroundings it mirrors.
    pub mirror: f64,
    /// Light of its own, as the sky has it.
    pub glow: f64,
    seed: u32,
}

impl Material {
    /// A random look for what is `distance` metres from cameras whose pixels are `pixel` wide at 1 m.
    pub fn random(chance: &mut Chance, frame: [V; 3], distance: f64, pixel: f64) -> Self {
        use Pattern::{Bricks, Checks, Clouds, Panes, Plain, Spots, Stripes};
        let patterns = [Plain, Plain, Clouds, Clouds, Clouds, Checks, Bricks, Stripes, Spots, Panes];
        let first = chance.point([0.08; 3], [0.85; 3]);
        let gray = chance.within(0.3, 1.0); // most things have little colour
        let level = (first[0] + first[1] + first[2]) / 3.0;
        let first = first.map(|v| v * (1.0 - gray) + level * gray);
        let share = chance.within(0.3, 1.7);
        let second = first.map(|v| (v * share).min(0.95));
        let strength = if chance.happens(0.25) { chance.within(0.01, 0.1) } else { chance.within(0.1, 0.9) };
        Self {
            pattern: patterns[chance.below(10) as usize],
            colours: [first, second],
            frame,
            cell: pixel * distance * chance.skewed(4.0, 90.0),
            noise: [strength, pixel * distance * chance.skewed(2.0, 60.0), chance.within(0.45, 1.0)],
            gloss: if chance.happens(0.35) { chance.skewed(0.1, 1.5) } else { 0.0 },
            mirror: if chance.happens(0.12) { chance.within(0.05, 0.5) } else { 0.0 },
            glow: 0.0,
            seed: chance.bits() as u32,
        }
    }

    /// As it is, with the weak, fine grain of asphalt, plaster or cloth.
    pub fn grained(mut self, chance: &mut Chance, distance: f64, pixel: f64) -> Self {
        self.pattern = if chance.happens(0.7) { Pattern::Plain } else { Pattern::Clouds };
        self.noise = [chance.within(0.03, 0.35), pixel * distance * chance.within(2.0, 16.0), chance.within(0.7, 1.1)];
        self
    }

    /// As it is, with rows of windows.
    pub fn with_windows(mut self, cell: f64) -> Self {
        (self.pattern, self.cell) = (Pattern::Panes, cell);
        self
    }

    /// As it is, a light.
    pub fn glowing(mut self, glow: f64) -> Self {
        (self.glow, self.gloss, self.mirror, self.pattern) = (glow, 0.0, 0.0, Pattern::Clouds);
        self
    }

    /// The colour at `point`, of which a pixel sees `footprint` metres.
    pub fn colour(&self, point: V, footprint: f64) -> V {
        let local = self.frame.map(|axis| dot(axis, point));
        let [mut strength, mut period, fade] = self.noise;
        let mut noise = 0.0;
        for octave in 0..7 {
            if period < footprint {
                break;
            }
            noise += strength * (value_noise(local.map(|v| v / period), self.seed.wrapping_add(octave)) - 0.5);
            (strength, period) = (strength * fade, period / 2.0);
        }
        let mix = if self.cell < 2.0 * footprint { 0.5 } else { self.mix(local.map(|v| v / self.cell)) };
        let brightness = (1.0 + noise).max(0.05);
        std::array::from_fn(|i| (self.colours[0][i] * (1.0 - mix) + self.colours[1][i] * mix) * brightness)
    }

    /// How much of the second colour there is at a point in units of the period.
    fn mix(&self, at: V) -> f64 {
        let cell = at.map(f64::floor);
        let inner = [at[0] - cell[0], at[1] - cell[1], at[2] - cell[2]];
        let level = |x: f64, y: f64, z: f64| hash([x as i64, y as i64, z as i64], self.seed);
        let one = |yes: bool| f64::from(u8::from(yes));
        match self.pattern {
            Pattern::Plain => 0.0,
            Pattern::Clouds => {
                let broad = value_noise(at, self.seed ^ 1);
                ((broad - 0.5) * 3.0 + 0.5).clamp(0.0, 1.0)
            }
            Pattern::Checks => one((cell[0] + cell[1] + cell[2]).rem_euclid(2.0) < 0.5),
            Pattern::Bricks => {
                let along = at[1] / 2.0 + 0.5 * cell[2].rem_euclid(2.0);
                let mortar = along - along.floor() < 0.06 || inner[2] < 0.12;
                if mortar { 1.0 } else { 0.5 * level(along.floor(), cell[2], 0.0) }
            }
            Pattern::Stripes => one(inner[2] < 0.3 + 0.4 * level(0.0, 0.0, cell[2])),
            Pattern::Spots => {
                let centre = [0.0, 1.0, 2.0].map(|k| 0.3 + 0.4 * level(cell[0] + 7.0 * k, cell[1], cell[2]));
                let square = (0..3).map(|i| (inner[i] - centre[i]) * (inner[i] - centre[i])).sum::<f64>();
                one(square < 0.09)
            }
            Pattern::Panes => {
                let frame = inner[1] < 0.25 || inner[2] < 0.3;
                if frame { 0.0 } else { 0.4 + 0.6 * level(cell[1], cell[2], cell[0]) }
            }
        }
    }
}
