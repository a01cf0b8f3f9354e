//! Shapes beyond those of the corridor.

use super::chance::cross;
use crate::caster::{Shape, V, add, dot, roots, unit};

/// What a ray can hit.
pub enum Solid {
    /// One of the corridor's shapes.
    Plain(Shape),
    /// A rectangle: a corner and two edges at right angles.
    Sheet { corner: V, edges: [V; 2] },
    /// A box: its centre, its directions at right angles, half its length along each.
    Block { centre: V, axes: [V; 3], half: V },
    /// A round pole without ends.
    Pole { foot: V, axis: V, length: f64, radius: f64 },
}

impl Solid {
    /// The smallest t > `after` at which `from + t * along` lies on the solid.
    pub fn hit(&self, from: V, along: V, after: f64) -> Option<f64> {
        match self {
            Solid::Plain(shape) => shape.hit(from, along, after),
            Solid::Sheet { corner, edges } => {
                let normal = cross(edges[0], edges[1]);
                let t = dot(add(*corner, from, -1.0), normal) / dot(along, normal);
                let inner = add(add(from, along, t), *corner, -1.0);
                let inside = edges.iter().all(|&e| (0.0..=dot(e, e)).contains(&dot(inner, e)));
                (t > after && t.is_finite() && inside).then_some(t)
            }
            Solid::Block { centre, axes, half } => {
                let offset = add(from, *centre, -1.0);
                let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
                for (axis, half) in axes.iter().zip(half) {
                    let (o, d) = (dot(offset, *axis), dot(along, *axis));
                    let ends = [(-half - o) / d, (half - o) / d];
                    near = near.max(ends[0].min(ends[1]));
                    far = far.min(ends[0].max(ends[1]));
                }
                let t = if near > after { near } else { far };
                (near <= far && t > after).then_some(t)
            }
            Solid::Pole { foot, axis, length, radius } => {
                let offset = add(from, *foot, -1.0);
                let across = |v: V| add(v, *axis, -dot(v, *axis));
                let (o, d) = (across(offset), across(along));
                let height = |t: f64| dot(add(offset, along, t), *axis);
                let ends = roots(dot(d, d), dot(o, d), dot(o, o) - radius * radius);
                ends.into_iter().find(|&t| t > after && (0.0..=*length).contains(&height(t)))
            }
        }
    }

    /// The normal at `point`, towards `from`.
    pub fn normal(&self, point: V, from: V) -> V {
        let normal = match self {
            Solid::Plain(shape) => return shape.normal(point, from),
            Solid::Sheet { edges, .. } => unit(cross(edges[0], edges[1])),
            Solid::Block { centre, axes, half } => {
                let offset = add(point, *centre, -1.0);
                let share = |i: usize| dot(offset, axes[i]).abs() / half[i];
                axes[(1..3).fold(0, |best, i| if share(i) > share(best) { i } else { best })]
            }
            Solid::Pole { foot, axis, .. } => {
                let offset = add(point, *foot, -1.0);
                unit(add(offset, *axis, -dot(offset, *axis)))
            }
        };
        if dot(normal, add(from, point, -1.0)) < 0.0 { normal.map(|v| -v) } else { normal }
    }
}
