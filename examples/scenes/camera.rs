//! How a pair of cameras sees a scene: light, exposure, blur, noise; and the truth.

use rayon::prelude::*;

use super::chance::Chance;
use super::layout::{Scene, Thing};
use crate::caster::{V, add, dot, hash, unit, value_noise};

/// The cameras: the left one at the origin, x to the right, y downwards, z forwards, in metres; pixel centres at whole coordinates.
pub struct View {
    pub width: usize,
    pub height: usize,
    pub focal: f64,
    pub baseline: f64,
}

/// One camera of the pair, and how it makes a picture of the light.
#[derive(Clone)]
pub struct Side {
    /// Its x.
    pub x: f64,
    /// How much lower than it should be it reads its rows, in pixels.
    pub lowered: f64,
    /// The side of the square that a pixel sees, in pixels.
    pub blur: f64,
    /// What the light is multiplied by; how much darker the corners are; light that lies over all.
    pub gain: f64,
    pub vignette: f64,
    pub veil: f64,
    /// How much of its curve is a root, and how much a straight line.
    pub curve: f64,
    /// The standard deviation of its noise in the dark, and of that which grows with the light.
    pub noise: [f64; 2],
    pub seed: u32,
}

/// What a camera sees.
pub struct Picture {
    pub samples: Vec<u8>,
    pub disparities: Vec<f64>,
}

/// The first thing on a ray, and where.
fn first(scene: &Scene, from: V, along: V, after: f64) -> Option<(&Thing, f64)> {
    let hits = scene.things.iter().filter_map(|thing| thing.solid.hit(from, along, after).map(|t| (thing, t)));
    hits.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The light that leaves the scene at the end of a ray, whose pixel is `pixel` wide at 1 m.
fn radiance(scene: &Scene, camera: V, along: V, pixel: f64) -> V {
    let Some((thing, z)) = first(scene, camera, along, 0.0) else { return [0.0; 3] };
    let point = add(camera, along, z);
    let colour = thing.material.colour(point, z * pixel);
    if thing.material.glow > 0.0 {
        return colour.map(|v| v * thing.material.glow);
    }
    let to_light = add(scene.light, point, -1.0);
    let lit = first(scene, point, to_light, 1e-6).is_none_or(|(other, t)| t > 1.0 || other.material.glow > 0.0);
    let (normal, back) = (thing.solid.normal(point, camera), unit(along.map(|v| -v)));
    let facing = dot(normal, unit(to_light)).max(0.0);
    let sun = if lit { scene.sun } else { 0.0 };
    let mut sum = colour.map(|v| v * (scene.ambient + sun * facing));
    if sun > 0.0 && thing.material.gloss > 0.0 {
        let mut shine = dot(normal, unit(add(unit(to_light), back, 1.0))).max(0.0);
        for _ in 0..5 {
            shine *= shine;
        }
        sum = sum.map(|v| v + sun * thing.material.gloss * shine);
    }
    if thing.material.mirror > 0.0 {
        let mirrored = add(normal.map(|v| v * 2.0 * dot(normal, back)), back, -1.0);
        let around = value_noise(mirrored.map(|v| 3.0 * v), 11) + 0.5 * value_noise(mirrored.map(|v| 11.0 * v), 12);
        sum = sum.map(|v| v * (1.0 - thing.material.mirror) + thing.material.mirror * around * around);
    }
    sum
}

impl View {
    /// The ray through (x, y) of the image, of length 1 along z, so that its parameter is the depth z.
    fn ray(&self, x: f64, y: f64) -> V {
        let centre = |size: usize| (size - 1) as f64 / 2.0;
        [(x - centre(self.width)) / self.focal, (y - centre(self.height)) / self.focal, 1.0]
    }

    /// The depth of the first thing behind each pixel's centre, seen from `x`.
    pub fn depths(&self, scene: &Scene, x: f64) -> Vec<f64> {
        let depth = |i: usize| {
            let ray = self.ray((i % self.width) as f64, (i / self.width) as f64);
            first(scene, [x, 0.0, 0.0], ray, 0.0).map_or(f64::INFINITY, |(_, z)| z)
        };
        (0..self.width * self.height).into_par_iter().map(depth).collect()
    }

    /// 255 for each pixel of the left image whose point the right camera sees, in a pixel of its image; 0 for the others.
    pub fn visible_from_right(&self, scene: &Scene, disparities: &[f64]) -> Vec<u8> {
        let visible = |(i, &d): (usize, &f64)| {
            let x = (i % self.width) as f64 - d;
            let ray = self.ray(x, (i / self.width) as f64);
            let z = first(scene, [self.baseline, 0.0, 0.0], ray, 0.0).map_or(0.0, |(_, z)| z);
            let inside = (-0.5..self.width as f64 - 0.5).contains(&x);
            if inside && z > self.focal * self.baseline / d * (1.0 - 1e-9) { 255 } else { 0 }
        };
        disparities.par_iter().enumerate().map(visible).collect()
    }

    /// The light that reaches each pixel of a side, `samples` x `samples` rays a pixel, each somewhere in its part of the pixel.
    pub fn light(&self, scene: &Scene, side: &Side, samples: usize) -> Vec<V> {
        let rows = (0..self.height).into_par_iter().flat_map_iter(|y| {
            (0..self.width).flat_map(move |x| {
                let mut sum = [0.0; 3];
                for sample in 0..samples * samples {
                    let somewhere = |axis: i64| hash([x as i64, y as i64, 2 * sample as i64 + axis], side.seed);
                    let at = |i: usize, axis: i64| (i as f64 + somewhere(axis)) / samples as f64 - 0.5;
                    let (dx, dy) = (at(sample % samples, 0) * side.blur, at(sample / samples, 1) * side.blur);
                    let ray = self.ray(x as f64 + dx, y as f64 + dy + side.lowered);
                    sum = add(sum, radiance(scene, [side.x, 0.0, 0.0], ray, 1.0 / self.focal), 1.0);
                }
                [sum.map(|v| v / (samples * samples) as f64)]
            })
        });
        rows.collect()
    }

    /// The samples, RGB, that a side makes of the light.
    pub fn exposed(&self, light: &[V], side: &Side) -> Vec<u8> {
        let sample = |i: usize, c: usize| {
            let across = |at: usize, size: usize| (at as f64 - (size - 1) as f64 / 2.0) / self.width as f64;
            let (x, y) = (across(i % self.width, self.width), across(i / self.width, self.height));
            let dimmed = side.gain * (1.0 - side.vignette * (x * x + y * y)) * light[i][c] + side.veil;
            let v = dimmed.clamp(0.0, 1.0);
            let bent = side.curve * v.sqrt() + (1.0 - side.curve) * v;
            // The sum of four even numbers has nearly a normal distribution.
            let sum: f64 = (0..4).map(|k| hash([i as i64, c as i64, k], side.seed ^ 0x5eed) - 0.5).sum();
            let spread = side.noise[0] + side.noise[1] * v.sqrt();
            (255.0 * bent + 1.732 * sum * spread + 0.5).clamp(0.0, 255.0) as u8
        };
        (0..light.len() * 3).into_par_iter().map(|k| sample(k / 3, k % 3)).collect()
    }
}

impl Side {
    /// A pair of sides, which differ more or less, and whose light has the mean `mean` on the left.
    pub fn random_pair(chance: &mut Chance, baseline: f64) -> [Side; 2] {
        let left = Side {
            x: 0.0,
            lowered: 0.0,
            blur: chance.skewed(1.0, 2.2),
            gain: chance.within(0.14, 0.45),
            vignette: if chance.happens(0.3) { chance.within(0.0, 1.2) } else { 0.0 },
            veil: if chance.happens(0.2) { chance.within(0.0, 0.15) } else { 0.0 },
            curve: chance.within(0.3, 1.0),
            noise: [chance.skewed(0.2, 4.0), chance.skewed(0.0, 5.0)],
            seed: chance.bits() as u32,
        };
        let mut right = Side { x: baseline, seed: chance.bits() as u32, ..left.clone() };
        right.lowered = if chance.happens(0.6) { chance.within(-0.35, 0.35) } else { 0.0 };
        right.blur = left.blur * if chance.happens(0.4) { chance.within(0.8, 1.4) } else { 1.0 };
        right.gain = left.gain * if chance.happens(0.6) { chance.within(0.65, 1.45) } else { 1.0 };
        right.curve = if chance.happens(0.2) { chance.within(0.3, 1.0) } else { left.curve };
        [left, right]
    }
}
