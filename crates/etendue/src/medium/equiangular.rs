//! Distances along a segment that are spread evenly in angle about a point.

use super::Segment;
use crate::math::Vec3;
use std::f64::consts::FRAC_PI_2;

/// Least distance of the point from the segment's line, over its distance from the segment's beginning: keeps angles finite
/// where the line goes through the point.
const LEAST: f64 = 1e-6;

/// Distances along a segment, uniform in the angle at which an anchor sees them, so that their density goes with the inverse
/// square of the distance from the anchor (Kulla and Fajardo, "Importance Sampling Techniques for Path Tracing in Participating
/// Media", 2012).
///
/// With r the anchor's distance from the segment's beginning, a its distance along the segment and h that from the segment's
/// line, the point at distance t and the beginning are seen under an angle phi with t = r^2 sin(phi) / (h cos(phi) + a sin(phi)):
/// no difference of inverse tangents, so no digits are lost however far the anchor or the segment's end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equiangular {
    along: f64,
    off: f64,
    /// Under which the anchor sees the segment, in (0, pi).
    angle: f64,
    length: f32,
}

impl Equiangular {
    /// `anchor` is relative to the scene's centre. `None` where no angle can be told: the segment has no length, begins at the
    /// anchor, or something is not finite (its length may be infinite).
    pub fn new(segment: &Segment, anchor: Vec3) -> Option<Self> {
        let direction = segment.direction.as_dvec3();
        let to_anchor = anchor.as_dvec3() - segment.origin.as_dvec3();
        let along = to_anchor.dot(direction);
        let off = (to_anchor - direction * along).length().max(LEAST * to_anchor.length());
        let length = f64::from(segment.length);
        // Seen from the anchor, beginning and end are at (-along, off) and (length - along, off).
        let angle = if length.is_finite() {
            libm::atan2(length * off, off * off + along * (along - length))
        } else {
            FRAC_PI_2 + libm::atan2(along, off)
        };
        let usable = length > 0.0 && off > 0.0 && off.is_finite() && along.is_finite() && angle > 0.0;
        usable.then_some(Self { along, off, angle, length: segment.length })
    }

    /// The distance for a number in [0, 1); `None` where it is beyond all numbers.
    pub fn sample(&self, u: f32) -> Option<f32> {
        let (sin, cos) = libm::sincos(f64::from(u) * self.angle);
        let below = self.off * cos + self.along * sin;
        let distance = ((self.off * self.off + self.along * self.along) * sin / below) as f32;
        (below > 0.0 && distance.is_finite()).then(|| distance.min(self.length))
    }

    /// Density per metre of a distance inside of the segment.
    pub fn pdf(&self, distance: f32) -> f32 {
        let beyond = f64::from(distance) - self.along;
        (self.off / (self.angle * (self.off * self.off + beyond * beyond))) as f32
    }

    /// Metres from the segment's beginning to where distances end.
    pub fn length(&self) -> f32 {
        self.length
    }

    /// Least distance of the anchor from the segment, metres.
    pub fn nearest(&self) -> f32 {
        let beyond = (self.along - f64::from(self.length)).max(-self.along).max(0.0);
        (self.off * self.off + beyond * beyond).sqrt() as f32
    }
}
