//! What stands where.

use super::chance::{Chance, cross};
use super::material::Material;
use super::solid::Solid;
use crate::caster::{Shape, V, add, unit};

/// A solid and its look.
pub struct Thing {
    pub solid: Solid,
    pub material: Material,
}

/// Things and their light.
pub struct Scene {
    pub things: Vec<Thing>,
    pub light: V,
    pub ambient: f64,
    pub sun: f64,
}

/// Builds a scene; `pixel` is how wide a pixel is at 1 m.
struct Builder<'a> {
    chance: &'a mut Chance,
    pixel: f64,
    things: Vec<Thing>,
}

const UPRIGHT: [V; 3] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]];

/// A scene of a seed: a room, a street or a heap of things in the air.
pub fn random_scene(chance: &mut Chance, pixel: f64) -> Scene {
    let mut builder = Builder { chance, pixel, things: Vec::new() };
    let outside = match builder.chance.below(10) {
        0..4 => builder.street(),
        4..7 => builder.room(),
        _ => builder.heap(),
    };
    let Builder { chance, things, .. } = builder;
    let light = if outside {
        chance.point([-40.0, -60.0, -30.0], [40.0, -15.0, 40.0])
    } else {
        chance.point([-1.5, -1.2, -1.0], [1.5, -0.2, 3.0])
    };
    let sun = if chance.happens(0.25) { 0.0 } else { chance.within(0.2, 2.0) };
    Scene { things, light, ambient: chance.within(0.25, 1.0), sun }
}

impl Builder<'_> {
    fn material(&mut self, frame: [V; 3], distance: f64) -> Material {
        Material::random(self.chance, frame, distance, self.pixel)
    }

    fn put(&mut self, solid: Solid, material: Material) {
        self.things.push(Thing { solid, material });
    }

    /// A rectangle around `middle`, which looks towards `facing`, with half its size along the other two directions.
    fn sheet(&mut self, middle: V, frame: [V; 3], half: [f64; 2], material: Material) {
        let edges = [frame[1].map(|v| 2.0 * half[0] * v), frame[2].map(|v| 2.0 * half[1] * v)];
        let corner = add(add(middle, edges[0], -0.5), edges[1], -0.5);
        self.put(Solid::Sheet { corner, edges }, material);
    }

    /// Something random of about the size `size` at `at`.
    fn thing(&mut self, at: V, size: f64) {
        let upright = self.chance.happens(0.5);
        let frame = if upright { self.turned() } else { self.chance.frame([0.0, 0.0, -1.0], 1.5) };
        let material = self.material(frame, at[2]);
        let half = [0; 3].map(|_| size * self.chance.within(0.15, 1.0));
        match self.chance.below(10) {
            0..3 => self.put(Solid::Block { centre: at, axes: frame, half }, material),
            3..5 => self.put(Solid::Plain(Shape::Sphere { centre: at, radius: half[0] }), material),
            5 => {
                let height = size * self.chance.within(0.5, 2.0);
                self.put(Solid::Plain(Shape::Cone { apex: at, height, radius: half[0] }), material);
            }
            6..8 => {
                // Something thin: a few pixels wide.
                let axis = if upright { [0.0, -1.0, 0.0] } else { self.chance.direction() };
                let radius = self.pixel * at[2] * self.chance.skewed(0.7, 6.0);
                let length = size * self.chance.within(1.0, 5.0);
                self.put(Solid::Pole { foot: add(at, axis, -0.5 * length), axis, length, radius }, material);
            }
            _ => self.sheet(at, frame, [half[0], half[1]], material),
        }
    }

    /// Upright directions, turned about the vertical.
    fn turned(&mut self) -> [V; 3] {
        let side = unit([self.chance.within(-1.0, 1.0), 0.0, self.chance.within(-1.0, 1.0) - 0.01]);
        [side, cross([0.0, 1.0, 0.0], side), [0.0, 1.0, 0.0]]
    }

    /// A room with things in it. False: the light is inside.
    fn room(&mut self) -> bool {
        let depth = self.chance.within(2.0, 6.0);
        let (left, right) = (-self.chance.within(0.5, 1.6), self.chance.within(0.5, 1.6));
        let (above, below) = (-self.chance.within(0.5, 1.5), self.chance.within(0.3, 0.9));
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let walls = [
            (x, [left, 0.0, depth / 2.0]),
            (x, [right, 0.0, depth / 2.0]),
            (y, [0.0, above, depth / 2.0]),
            (y, [0.0, below, depth / 2.0]),
            (z, [0.0, 0.0, depth]),
        ];
        for (facing, middle) in walls {
            let tilt = self.chance.within(0.0, 0.25);
            let facing = unit(add(facing, self.chance.direction(), tilt));
            let second = unit(cross(facing, if facing[1].abs() > 0.7 { x } else { y }));
            let frame = [facing, second, cross(facing, second)];
            let mut material = self.material(frame, 0.6 * depth);
            if self.chance.happens(0.35) {
                material = material.grained(self.chance, 0.6 * depth, self.pixel);
            }
            self.sheet(middle, frame, [8.0, 8.0], material);
        }
        let material = self.material(UPRIGHT, 8.0);
        self.put(Solid::Plain(Shape::Plane { axis: 2, at: 12.0 }), material);
        for _ in 0..self.chance.below(16) + 6 {
            let z = depth * self.chance.within(0.3, 1.0);
            let at = self.chance.point([left, above, z], [right, below, z]);
            let size = self.chance.within(0.06, 0.6);
            self.thing(at, size);
        }
        false
    }

    /// A street: a road, houses on both sides, cars, poles, trees. True: the light is the sun.
    fn street(&mut self) -> bool {
        let sky = self.material(UPRIGHT, 80.0).glowing(self.chance.within(1.0, 6.0));
        self.put(Solid::Plain(Shape::Plane { axis: 2, at: 400.0 }), sky);
        let ground = self.chance.within(1.2, 2.0);
        let slope = unit([self.chance.within(-0.03, 0.03), -1.0, self.chance.within(-0.03, 0.03)]);
        let across = unit(cross(slope, [0.0, 0.0, 1.0]));
        let frame = [slope, across, cross(slope, across)];
        let road = self.material(frame, 10.0).grained(self.chance, 10.0, self.pixel);
        self.sheet([0.0, ground, 100.0], frame, [200.0, 200.0], road);
        for side in [-1.0, 1.0] {
            let x = side * self.chance.within(3.5, 9.0);
            let mut z = self.chance.within(-2.0, 6.0);
            while z < 70.0 {
                let (length, height) = (self.chance.within(4.0, 14.0), self.chance.within(2.5, 9.0));
                let centre = [x + side * 3.0, ground - height / 2.0, z + length / 2.0];
                let setback = self.chance.within(0.0, 1.5);
                let mut wall = self.material([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]], z.max(6.0));
                if self.chance.happens(0.5) {
                    wall = wall.with_windows(self.chance.within(0.8, 2.5));
                }
                let half = [3.0 - setback, height / 2.0, length / 2.0];
                self.put(
                    Solid::Block { centre, axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], half },
                    wall,
                );
                z += length + self.chance.skewed(0.0, 6.0);
            }
        }
        for _ in 0..self.chance.below(7) + 1 {
            self.car(ground);
        }
        for _ in 0..self.chance.below(8) + 2 {
            let foot = [self.chance.within(-7.0, 7.0), ground, self.chance.within(4.0, 35.0)];
            let material = self.material(UPRIGHT, foot[2]);
            let (length, radius) = (self.chance.within(1.0, 6.0), self.chance.skewed(0.02, 0.14));
            self.put(Solid::Pole { foot, axis: [0.0, -1.0, 0.0], length, radius }, material);
            if self.chance.happens(0.4) {
                let radius = self.chance.within(0.4, 1.8);
                let material = self.material(UPRIGHT, foot[2]);
                self.put(Solid::Plain(Shape::Sphere { centre: add(foot, [0.0, -length, 0.0], 1.0), radius }), material);
            }
        }
        for _ in 0..self.chance.below(6) {
            let at = self.chance.point([-6.0, ground - 2.0, 4.0], [6.0, ground, 25.0]);
            let size = self.chance.within(0.2, 1.2);
            self.thing(at, size);
        }
        true
    }

    /// A car: a box with a smaller one on it, of glossy paint and dark windows, mostly along the street.
    fn car(&mut self, ground: f64) {
        let at = [self.chance.within(-5.0, 5.0), ground, self.chance.within(5.0, 35.0)];
        let side = unit([1.0, 0.0, self.chance.within(-0.15, 0.15)]);
        let axes = [side, [0.0, 1.0, 0.0], cross(side, [0.0, 1.0, 0.0])];
        let mut paint = self.material(axes, at[2]);
        if self.chance.happens(0.7) {
            paint = paint.grained(self.chance, at[2], self.pixel);
        }
        paint.gloss = self.chance.within(0.2, 1.5);
        paint.mirror = self.chance.within(0.05, 0.45);
        let mut glass = self.material(axes, at[2]).grained(self.chance, at[2], self.pixel);
        glass.mirror = self.chance.within(0.2, 0.7);
        let half = [self.chance.within(0.75, 0.95), self.chance.within(0.3, 0.45), self.chance.within(1.7, 2.4)];
        let body = add(at, [0.0, -half[1] - 0.25, 0.0], 1.0);
        self.put(Solid::Block { centre: body, axes, half }, paint);
        let cabin = add(body, [0.0, -half[1] - 0.28, 0.2], 1.0);
        self.put(Solid::Block { centre: cabin, axes, half: [half[0] * 0.88, 0.3, half[2] * 0.55] }, glass);
    }

    /// A heap of things before a background. False: the light is near.
    fn heap(&mut self) -> bool {
        let depth = self.chance.within(3.0, 6.0);
        let frame = self.chance.frame([0.0, 0.0, -1.0], 0.5);
        let material = self.material(frame, depth);
        self.sheet([0.0, 0.0, depth], frame, [30.0, 30.0], material);
        let material = self.material(UPRIGHT, 9.0);
        self.put(Solid::Plain(Shape::Plane { axis: 2, at: 14.0 }), material);
        for _ in 0..self.chance.below(25) + 8 {
            let z = self.chance.within(1.0, depth);
            let at = self.chance.point([-0.6 * z, -0.45 * z, z], [0.6 * z, 0.45 * z, z]);
            let size = z * self.chance.within(0.03, 0.4);
            self.thing(at, size);
        }
        false
    }
}
