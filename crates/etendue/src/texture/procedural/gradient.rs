//! Colours along a line or about a point.

use super::{Coordinates, Place};
use crate::{
    math::{Vec2, Vec3},
    spectrum::Spectrum,
    texture::{Lookup, UvTransform},
};

/// A colour of a gradient, and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// 0 at the gradient's beginning, 1 at its end.
    pub at: f32,
    /// Linear.
    pub color: Spectrum,
}

/// Colours along the line from one point to another, or about a point; linear between stops, and the same beyond the first and
/// last.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// What `from` and `to` are in.
    pub coordinates: Coordinates,
    /// Where it is 0.
    pub from: Vec3,
    /// Where it is 1; of a radial gradient one such point of the rim. Not `from`.
    pub to: Vec3,
    /// By the distance from `from`, not along the line.
    pub radial: bool,
    /// At least one, in ascending order.
    pub stops: Box<[Stop]>,
}

/// Narrower intervals count as points.
const NARROW: f32 = 1e-3;

impl Gradient {
    /// The place along the gradient, and its extent there.
    fn along(&self, place: &Place) -> (f32, f32) {
        let (offset, whole) = (place.point - self.from, self.to - self.from);
        let length = whole.length();
        let (distance, direction) = if self.radial {
            (offset.length(), offset.try_normalize().unwrap_or(Vec3::X))
        } else {
            (offset.dot(whole) / length, whole / length)
        };
        (distance / length, place.extent(direction) / length)
    }

    pub(in crate::texture) fn color(&self, transform: &UvTransform, at: &Lookup) -> Spectrum {
        let (x, width) = self.along(&self.coordinates.place(transform, at));
        if width > NARROW && width.is_finite() {
            (self.integral(x + 0.5 * width) - self.integral(x - 0.5 * width)) / width
        } else {
            self.value(x)
        }
    }

    /// The stops about `x`: the number of those before it.
    fn before(&self, x: f32) -> usize {
        self.stops.partition_point(|stop| stop.at <= x)
    }

    fn value(&self, x: f32) -> Spectrum {
        match self.before(x) {
            0 => self.stops.first().map_or(Spectrum::BLACK, |stop| stop.color),
            n if n == self.stops.len() => self.stops[n - 1].color,
            n => {
                let (a, b) = (self.stops[n - 1], self.stops[n]);
                let share = (x - a.at) / (b.at - a.at);
                a.color * (1.0 - share) + b.color * share
            }
        }
    }

    /// The integral of the colour from the first stop to `x`.
    fn integral(&self, x: f32) -> Spectrum {
        let before = self.before(x);
        let Some(first) = self.stops.first() else { return Spectrum::BLACK };
        if before == 0 {
            return first.color * (x - first.at);
        }
        let area = |a: f32, b: f32, from: Spectrum, to: Spectrum| (from + to) * (0.5 * (b - a));
        let pairs = self.stops[..before].windows(2).map(|s| area(s[0].at, s[1].at, s[0].color, s[1].color));
        let last = self.stops[before - 1];
        pairs.fold(area(last.at, x, last.color, self.value(x)), |sum, area| sum + area)
    }

    /// Least and most of any channel.
    pub(in crate::texture) fn range(&self) -> [f32; 2] {
        let low = self.stops.iter().map(|stop| stop.color.min_component()).fold(f32::INFINITY, f32::min);
        let high = self.stops.iter().map(|stop| stop.color.max_component()).fold(f32::NEG_INFINITY, f32::max);
        [low, high]
    }

    /// Steps along u and v that are fine enough to take slopes over.
    pub(in crate::texture) fn steps(&self, transform: &UvTransform, at: &Lookup) -> Vec2 {
        self.coordinates.steps(transform, at) * ((self.to - self.from).length() * (1.0 / 256.0))
    }
}
