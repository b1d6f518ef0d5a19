//! What flat lights share: which side the context is on, and the lifted target.

use super::{LightContext, LightSample, finite_density, margin, max_abs};
use crate::{
    bsdf::Density,
    math::{DVec3, Vec3},
    spectrum::Spectrum,
};

/// A flat light as seen from a context on an emitting side of it, farther from its plane than the margin.
pub(super) struct Facing {
    /// The context.
    point: DVec3,
    /// Unit normal on the context's side.
    normal: DVec3,
    /// Of the context over the plane, above `margin`.
    height: f64,
    /// Offset of targets along `normal`.
    margin: f64,
}

impl Facing {
    /// `cross` is along the front's normal, of any length. `None` if the light shows no emitting side, if the context is
    /// in its plane, or if anything is degenerate.
    #[inline]
    pub(super) fn new(ctx: &LightContext, corners: &[DVec3], cross: DVec3, two_sided: bool) -> Option<Self> {
        let point = ctx.point.as_dvec3();
        let front = cross / cross.length();
        let mut coordinate = max_abs(point);
        let mut distance = 0.0f64;
        for &corner in corners {
            coordinate = coordinate.max(max_abs(corner));
            distance = distance.max(max_abs(corner - point));
        }
        let margin = margin(coordinate, distance);
        let height = front.dot(point - corners[0]);
        if height > margin {
            Some(Self { point, normal: front, height, margin })
        } else if two_sided && height < -margin {
            Some(Self { point, normal: -front, height: -height, margin })
        } else {
            None
        }
    }

    /// Height of the context over the plane, metres, above 0.
    #[inline]
    pub(super) fn height(&self) -> f64 {
        self.height
    }

    /// A sample at `offset` from the context, drawn with `density` per solid angle; `at` as in [`LightSample`].
    #[inline]
    pub(super) fn sample(&self, offset: DVec3, at: [f64; 2], density: f64, radiance: Spectrum) -> Option<LightSample> {
        let density = finite_density(density)?;
        let length = offset.length();
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let wi = (offset / length).as_vec3();
        let at = at.map(|a| a as f32);
        Some(LightSample { wi, at, target: Some(self.target(offset)), radiance, density: Density::SolidAngle(density) })
    }

    /// The end of a shadow ray to the point at `offset` from the context.
    #[inline]
    pub(super) fn target(&self, offset: DVec3) -> Vec3 {
        (self.point + offset + self.normal * self.margin).as_vec3()
    }
}
