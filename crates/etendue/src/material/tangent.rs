//! Directions over a surface: which way its grooves and highlights run.

use super::Number;
use crate::{
    math::{DVec3, Frame, Vec3, sin_cos_turns},
    surface::Chart,
    texture::{Lookup, Texture},
};
use std::{f32::consts::TAU, sync::Arc};

/// The x axis of a material's shading frame, for BSDFs that have directions: along u for anisotropic GGX, and the reference
/// direction r of brushed metal, which its grooves run across.
#[derive(Clone, Debug, PartialEq)]
pub struct TangentField<T = Arc<Texture>> {
    /// Where it points, before it is turned.
    pub direction: Tangent,
    /// Turns it about the shading normal, counter-clockwise seen from the normal's side, radians.
    pub rotation: Number<T>,
}

/// A direction at each point of space; a surface takes what of it lies within its plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Tangent {
    /// Along growing u of the surface's texture coordinates.
    #[default]
    Uv,
    /// Everywhere the same: of any length but 0, world space.
    Constant(DVec3),
    /// Away from a point, or with an axis, from the line through the point along the axis.
    Radial {
        /// World space, metres.
        center: DVec3,
        /// Of any length but 0.
        axis: Option<DVec3>,
    },
    /// Round a point: counter-clockwise about the axis, or without one about the surface's normal.
    Tangential {
        /// World space, metres.
        center: DVec3,
        /// Of any length but 0.
        axis: Option<DVec3>,
    },
}

impl<T> Default for TangentField<T> {
    fn default() -> Self {
        Self { direction: Tangent::Uv, rotation: 0.0.into() }
    }
}

impl TangentField {
    /// The frame about the unit `normal` at a point of the world; `chart` and `lookup` are asked for only where they
    /// matter.
    /// Where the field has no direction within the surface (at its centre, or along the normal) x is some direction that
    /// depends on the normal alone.
    pub fn frame(
        &self,
        position: DVec3,
        normal: Vec3,
        chart: impl FnOnce() -> Chart,
        lookup: impl FnOnce() -> Lookup,
    ) -> Frame {
        let tangent = match self.direction {
            Tangent::Uv => chart().tangent(normal),
            Tangent::Constant(direction) => flat(direction, normal),
            Tangent::Radial { center, axis } => flat(away(position - center, axis), normal),
            Tangent::Tangential { center, axis } => {
                let about = axis.unwrap_or(normal.as_dvec3());
                flat(about.cross(position - center), normal)
            }
        };
        let frame = match tangent {
            Some(tangent) => Frame::from_tangent(normal, tangent),
            None => Frame::from_normal(normal),
        };
        let angle = match self.rotation.texture {
            None => self.rotation.factor,
            Some(_) => self.rotation.at(&lookup()),
        };
        if angle == 0.0 || !angle.is_finite() {
            return frame;
        }
        let (sin, cos) = sin_cos_turns(angle / TAU % 1.0);
        Frame::from_tangent(normal, (frame.s * cos + frame.t * sin).normalize())
    }
}

/// The part of `v` across the axis.
fn away(v: DVec3, axis: Option<DVec3>) -> DVec3 {
    match axis.and_then(DVec3::try_normalize) {
        Some(axis) => v - axis * axis.dot(v),
        None => v,
    }
}

/// The direction of `v` within the plane that the unit vector `normal` is perpendicular to; `None` where there is none.
fn flat(v: DVec3, normal: Vec3) -> Option<Vec3> {
    let length = v.length();
    let normal = normal.as_dvec3().normalize();
    let within = v - normal * normal.dot(v);
    // Less is rounding: of the normal in f32, and of what is subtracted.
    let has_direction = within.length() > 1e-6 * length && length > 1e-30;
    has_direction.then(|| within.normalize().as_vec3())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Vec2, dvec3, vec2, vec3};

    fn x_axis(direction: Tangent, degrees: f32, position: DVec3, normal: Vec3) -> Vec3 {
        let chart = || Chart { uv: vec2(0.0, 0.0), dpdu: vec3(0.0, 3.0, 1.0), dpdv: vec3(1.0, 0.0, 0.0) };
        let field = TangentField { direction, rotation: degrees.to_radians().into() };
        let frame = field.frame(position, normal, chart, || Lookup::new(Vec2::ZERO, Vec3::ZERO));
        for (a, b, expected) in [(frame.s, frame.t, 0.0), (frame.s, frame.s, 1.0), (frame.s, normal, 0.0)] {
            assert!((a.dot(b) - expected).abs() < 1e-6, "{frame:?}");
        }
        assert!((frame.s.cross(frame.t) - normal).length() < 1e-6);
        frame.s
    }

    #[track_caller]
    fn close(a: Vec3, b: Vec3) {
        assert!(a.distance(b) < 1e-6, "{a} {b}");
    }

    #[test]
    fn fields_point_where_they_should() {
        let (center, at) = (dvec3(1e6, 1.0, 2.0), dvec3(1e6, 4.0, 2.0));
        close(x_axis(Tangent::Uv, 0.0, at, Vec3::Z), Vec3::Y);
        close(x_axis(Tangent::Constant(dvec3(2.0, 0.0, 5.0)), 0.0, at, Vec3::Z), Vec3::X);
        close(x_axis(Tangent::Radial { center, axis: None }, 0.0, at, Vec3::Z), Vec3::Y);
        close(x_axis(Tangent::Tangential { center, axis: None }, 0.0, at, Vec3::Z), -Vec3::X);
        // The same turn about an axis, seen from the other side of the surface.
        close(x_axis(Tangent::Tangential { center, axis: None }, 0.0, at, -Vec3::Z), Vec3::X);
        let axis = Some(dvec3(0.0, 0.0, 2.0));
        close(x_axis(Tangent::Tangential { center, axis }, 0.0, at, -Vec3::Z), -Vec3::X);
        // On the side of a cylinder about the axis, round it.
        let on_side = center + dvec3(0.0, 3.0, 7.0);
        close(x_axis(Tangent::Tangential { center, axis }, 0.0, on_side, Vec3::Y), -Vec3::X);
        // From an axis: not along it.
        let slope = vec3(0.0, 1.0, 1.0).normalize();
        close(x_axis(Tangent::Radial { center, axis }, 0.0, on_side, slope), vec3(0.0, 1.0, -1.0).normalize());
    }

    #[test]
    fn rotation_is_counter_clockwise_from_the_normals_side() {
        let field = Tangent::Constant(DVec3::X);
        close(x_axis(field, 90.0, DVec3::ZERO, Vec3::Z), Vec3::Y);
        close(x_axis(field, 90.0, DVec3::ZERO, -Vec3::Z), -Vec3::Y);
        close(x_axis(field, -180.0, DVec3::ZERO, Vec3::Z), -Vec3::X);
        // Of many turns f32 keeps fewer digits.
        assert!(x_axis(field, 3600.0, DVec3::ZERO, Vec3::Z).distance(Vec3::X) < 1e-5);
    }

    /// Without a direction it is one all the same, the same each time.
    #[test]
    fn centres_and_poles_have_a_frame() {
        let center = dvec3(1.0, 2.0, 3.0);
        for (direction, at) in [
            (Tangent::Radial { center, axis: None }, center),
            (Tangent::Radial { center, axis: None }, center + dvec3(0.0, 0.0, 5.0)),
            (Tangent::Radial { center, axis: Some(DVec3::Z) }, center + dvec3(0.0, 0.0, 5.0)),
            (Tangent::Tangential { center, axis: None }, center),
            (Tangent::Constant(DVec3::Z), center),
            (Tangent::Constant(dvec3(1e-9, 0.0, 1.0)), center),
        ] {
            for degrees in [0.0, 30.0] {
                let first = x_axis(direction, degrees, at, Vec3::Z);
                assert_eq!(first, x_axis(direction, degrees, at, Vec3::Z));
            }
        }
        let tiny = x_axis(Tangent::Radial { center, axis: None }, 0.0, center + dvec3(1e-12, 0.0, 0.0), Vec3::Z);
        close(tiny, Vec3::X);
    }
}
