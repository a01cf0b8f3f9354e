//! What the examples that render scenes share: vectors, shapes that rays hit, noise, files.
//!
//! Only integer hashes, the four operations, floor and sqrt are used, which IEEE 754 defines to the bit: every platform computes
//! the same.

use std::array::from_fn;

use image::{ExtendedColorType, ImageEncoder, codecs::png};

/// A point, a direction or a colour.
pub type V = [f64; 3];

/// a + scale b.
pub fn add(a: V, b: V, scale: f64) -> V {
    from_fn(|i| a[i] + b[i] * scale)
}

/// The scalar product.
pub fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The direction of `a`, of length 1.
pub fn unit(a: V) -> V {
    let length = dot(a, a).sqrt();
    a.map(|v| v / length)
}

/// What a ray can hit.
pub enum Shape {
    /// All points whose coordinate `axis` is `at`.
    Plane {
        axis: usize,
        at: f64,
    },
    Sphere {
        centre: V,
        radius: f64,
    },
    /// Upright, open below.
    Cone {
        apex: V,
        height: f64,
        radius: f64,
    },
}

impl Shape {
    /// The smallest t > `after` at which `from + t * along` lies on the shape.
    pub fn hit(&self, from: V, along: V, after: f64) -> Option<f64> {
        match *self {
            Shape::Plane { axis, at } => Some((at - from[axis]) / along[axis]).filter(|&t| t > after && t.is_finite()),
            Shape::Sphere { centre, radius } => {
                let offset = add(from, centre, -1.0);
                let roots = roots(dot(along, along), dot(offset, along), dot(offset, offset) - radius * radius);
                roots.into_iter().find(|&t| t > after)
            }
            Shape::Cone { apex, height, radius } => {
                // x^2 + z^2 = slope y^2 seen from the apex: a dot product that counts y negatively.
                let slope = (radius / height) * (radius / height);
                let across = |a: V, b: V| a[0] * b[0] - slope * a[1] * b[1] + a[2] * b[2];
                let offset = add(from, apex, -1.0);
                let mut roots = roots(across(along, along), across(offset, along), across(offset, offset));
                roots.sort_by(f64::total_cmp);
                roots.into_iter().find(|&t| t > after && (0.0..=height).contains(&(offset[1] + t * along[1])))
            }
        }
    }

    /// The normal at `point`, towards `from`.
    pub fn normal(&self, point: V, from: V) -> V {
        let normal = match *self {
            Shape::Plane { axis, .. } => from_fn(|i| f64::from(u8::from(i == axis))),
            Shape::Sphere { centre, .. } => unit(add(point, centre, -1.0)),
            Shape::Cone { apex, height, radius } => {
                let offset = add(point, apex, -1.0);
                unit([offset[0], -offset[1] * (radius / height) * (radius / height), offset[2]])
            }
        };
        if dot(normal, add(from, point, -1.0)) < 0.0 { normal.map(|v| -v) } else { normal }
    }
}

/// The solutions of a t^2 + 2 b t + c = 0, the smaller first where a > 0; NaN where there is none.
pub fn roots(a: f64, b: f64, c: f64) -> [f64; 2] {
    let root = (b * b - a * c).sqrt();
    [(-b - root) / a, (-b + root) / a]
}

/// Random values 0 to 1 at whole coordinates, interpolated between them.
pub fn value_noise(point: V, seed: u32) -> f64 {
    let base = point.map(f64::floor);
    let weight: V = from_fn(|i| {
        let t = point[i] - base[i];
        t * t * (3.0 - 2.0 * t)
    });
    let mut sum = 0.0;
    for corner in 0..8 {
        let far: [bool; 3] = from_fn(|i| corner >> i & 1 == 1);
        let share = |i: usize| if far[i] { weight[i] } else { 1.0 - weight[i] };
        sum += share(0) * share(1) * share(2) * hash(from_fn(|i| base[i] as i64 + i64::from(far[i])), seed);
    }
    sum
}

/// A random value 0 to 1 for a point of the lattice.
pub fn hash(point: [i64; 3], seed: u32) -> f64 {
    let mut h = seed;
    for v in point {
        h = (h ^ v as u32).wrapping_mul(0x7feb_352d);
        h = (h ^ h >> 15).wrapping_mul(0x846c_a68b);
        h ^= h >> 16;
    }
    f64::from(h) / f64::from(u32::MAX)
}

/// A little-endian PFM: rows from the bottom.
pub fn pfm(values: &[f64], width: usize) -> Vec<u8> {
    let mut bytes = format!("Pf\n{width} {}\n-1.0\n", values.len() / width).into_bytes();
    bytes.extend(values.chunks_exact(width).rev().flatten().flat_map(|&v| (v as f32).to_le_bytes()));
    bytes
}

/// A PNG of samples of 8 bits.
pub fn png(samples: &[u8], width: usize, colour: ExtendedColorType) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let mut bytes = Vec::new();
    let encoder = png::PngEncoder::new_with_quality(&mut bytes, png::CompressionType::Best, png::FilterType::Adaptive);
    let height = samples.len() * 8 / colour.bits_per_pixel() as usize / width;
    encoder.write_image(samples, width as u32, height as u32, colour)?;
    Ok(bytes)
}
