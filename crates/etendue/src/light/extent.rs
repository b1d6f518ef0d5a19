//! Where a light is and which way it shines: what the choice among lights goes by.

use super::Light;
use crate::math::{DVec3, Vec3};
use std::f32::consts::PI;

/// Bounds of a light at some place, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    /// Corners of a box about it.
    pub low: Vec3,
    pub high: Vec3,
    /// The middle of the directions in which it shines, unit length.
    pub axis: Vec3,
    /// Normals are within this angle of `axis`, radians; pi: of all directions.
    pub spread: f32,
    /// Light is sent up to this angle from a normal, in proportion to the cosine.
    pub beyond: f32,
    /// Shines along -`axis` alike.
    pub two_sided: bool,
}

impl Extent {
    /// Of a flat light; `cross` is along the front's normal.
    fn flat(corners: &[DVec3], cross: DVec3, two_sided: bool) -> Self {
        let axis = cross.normalize_or_zero().as_vec3();
        Self { axis, spread: 0.0, beyond: 0.5 * PI, two_sided, ..Self::everywhere(corners) }
    }

    /// Of what shines in all directions.
    fn everywhere(corners: &[DVec3]) -> Self {
        let low = corners.iter().fold(DVec3::INFINITY, |low, c| low.min(*c)).as_vec3();
        let high = corners.iter().fold(DVec3::NEG_INFINITY, |high, c| high.max(*c)).as_vec3();
        Self { low, high, axis: Vec3::Z, spread: PI, beyond: 0.5 * PI, two_sided: false }
    }

    /// `None` for light from infinity, and where something is not finite.
    pub fn of(light: &Light) -> Option<Self> {
        let extent = match light {
            Light::Triangle(light) => {
                let [a, b, c] = light.vertices.map(|v| v.as_dvec3());
                Self::flat(&[a, b, c], (b - a).cross(c - a), light.two_sided)
            }
            Light::Rectangle(light) => {
                let [corner, u, v] = [light.corner, light.u, light.v].map(|v| v.as_dvec3());
                Self::flat(&[corner, corner + u, corner + u + v, corner + v], u.cross(v), light.two_sided)
            }
            Light::Disk(light) => {
                let (center, normal) = (light.outline.center(), light.outline.normal());
                let half = (DVec3::ONE - normal * normal).max(DVec3::ZERO).map(f64::sqrt) * light.outline.radius();
                Self::flat(&[center - half, center + half], normal, light.two_sided)
            }
            Light::Sphere(light) => {
                let [x, y, z] = light.axes.map(|a| a.as_dvec3());
                let half = (x * x + y * y + z * z).map(f64::sqrt);
                let center = light.center.as_dvec3();
                Self::everywhere(&[center - half, center + half])
            }
            Light::Point(light) => Self::everywhere(&[light.position.as_dvec3()]),
            Light::Spot(light) => {
                let angle = libm::acosf(light.cos_outer.clamp(-1.0, 1.0));
                // Much the same in all of the cone, and nothing beyond.
                let all = Self::everywhere(&[light.position.as_dvec3()]);
                Self { axis: light.axis, spread: angle, beyond: 0.0, ..all }
            }
            Light::Directional(_) | Light::Environment(_) | Light::Image(_) | Light::SunSky(_) => return None,
        };
        (extent.low.is_finite() && extent.high.is_finite() && extent.axis.is_finite()).then_some(extent)
    }

    pub fn middle(&self) -> Vec3 {
        self.low * 0.5 + self.high * 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        light::{DirectionalLight, RectangleLight, SphereLight},
        math::vec3,
        spectrum::Spectrum,
    };

    #[test]
    fn extents_hold_their_lights() {
        let radiance = Spectrum::ONE;
        let rectangle = RectangleLight { corner: Vec3::ONE, u: Vec3::X * 2.0, v: Vec3::Z, radiance, two_sided: false };
        let extent = Extent::of(&Light::Rectangle(rectangle)).expect("is somewhere");
        assert_eq!((extent.low, extent.high), (Vec3::ONE, vec3(3.0, 1.0, 2.0)));
        assert_eq!((extent.axis, extent.spread, extent.middle()), (Vec3::NEG_Y, 0.0, vec3(2.0, 1.0, 1.5)));
        let sphere = Extent::of(&Light::Sphere(SphereLight::round(Vec3::X, 2.0, radiance))).expect("is somewhere");
        assert_eq!((sphere.low, sphere.high, sphere.spread), (vec3(-1.0, -2.0, -2.0), vec3(3.0, 2.0, 2.0), PI));
        let sun = Light::Directional(DirectionalLight { direction: Vec3::X, irradiance: radiance });
        assert_eq!(Extent::of(&sun), None);
        let nowhere = Light::Sphere(SphereLight::round(Vec3::INFINITY, 2.0, radiance));
        assert_eq!(Extent::of(&nowhere), None);
    }
}
