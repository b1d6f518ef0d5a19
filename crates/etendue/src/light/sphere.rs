//! Emissive spheres and ellipsoids.

use super::{
    Arcs, Emitter, LightCircle, LightContext, LightSample, Reached, cap::ProjectedCap, environment, finite_density,
    larger, margin, max_abs, planar::DrawnPoint,
};
use crate::{
    bsdf::Density,
    math::{DMat3, DVec3, Frame, Vec3, sin_cos_turns, vec3},
    spectrum::Spectrum,
};
use std::f64::consts::PI;

/// An emissive ellipsoid: the image of the unit sphere under an affine map. From outside its visible cone is sampled
/// uniformly in the space where it is a unit sphere (so uniformly in solid angle where the map is a similarity), that of a sphere by
/// projected solid angle where light is gathered on one side of a surface; from inside, if it emits inward, directions are drawn as
/// for an environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereLight {
    /// Metres.
    pub center: Vec3,
    /// Images of the unit vectors, metres: columns of the linear map; three vectors of length R at right angles for a
    /// sphere of radius R.
    pub axes: [Vec3; 3],
    /// W sr^-1 m^-2.
    pub radiance: Spectrum,
    /// Emits inward too.
    pub two_sided: bool,
}

/// The light in the space where it is the unit sphere at the origin.
struct View {
    /// Unit sphere to world, about the centre.
    map: DMat3,
    inverse: DMat3,
    /// |det| of `map`.
    volume: f64,
    /// The context.
    point: DVec3,
    /// Its distance from the centre.
    distance: f64,
    /// Offset of targets, world space.
    margin: f64,
    side: Side,
}

/// Where the context is.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Outside,
    /// On the surface, within rounding; only for spheres that emit inward.
    On,
    Inside,
}

/// The cone under which the unit sphere is seen from a distance above 1.
struct Cone {
    /// Squared sine of the half angle.
    sin2: f64,
    /// 1 - cosine of the half angle.
    versine: f64,
}

impl Cone {
    #[inline]
    fn new(distance: f64) -> Self {
        let sin2 = 1.0 / (distance * distance);
        let cos = ((distance - 1.0) * (distance + 1.0)).sqrt() / distance;
        Self { sin2, versine: sin2 / (1.0 + cos) }
    }
}

impl View {
    /// True if the point at `distance` along `direction`, a unit vector of the world in the sphere's space, is on the side that
    /// faces the context.
    #[inline]
    fn is_near(&self, direction: DVec3, distance: f32) -> bool {
        (self.point + direction * f64::from(distance)).dot(direction) <= 0.0
    }
}

impl SphereLight {
    /// A sphere of `radius` metres that emits outward.
    pub fn round(center: Vec3, radius: f32, radiance: Spectrum) -> Self {
        let axes = [vec3(radius, 0.0, 0.0), vec3(0.0, radius, 0.0), vec3(0.0, 0.0, radius)];
        Self { center, axes, radiance, two_sided: false }
    }

    #[inline]
    fn map(&self) -> DMat3 {
        let [x, y, z] = self.axes.map(|a| a.as_dvec3());
        DMat3::from_cols(x, y, z)
    }

    /// `None` where the light shows no emitting side, or is degenerate.
    #[inline]
    fn view(&self, ctx: &LightContext) -> Option<View> {
        let map = self.map();
        let volume = map.determinant().abs();
        if !(volume > 0.0 && volume.is_finite()) {
            return None;
        }
        let inverse = map.inverse();
        let (world, center) = (ctx.point.as_dvec3(), self.center.as_dvec3());
        let point = inverse * (world - center);
        let distance = point.length();
        let extent = map.x_axis.length() + map.y_axis.length() + map.z_axis.length();
        let coordinate = max_abs(world).max(max_abs(center) + extent);
        let margin = margin(coordinate, max_abs(world - center) + extent);
        // To first order the world's distance from the surface is (distance - 1) over the gradient's length. The centre,
        // which has no gradient, is inside.
        let gradient = (inverse.transpose() * point).length() / distance;
        let height = (distance - 1.0) / gradient;
        let side = if height > margin {
            Side::Outside
        } else if !self.two_sided || !distance.is_finite() {
            return None;
        } else if height >= -margin {
            Side::On
        } else {
            Side::Inside
        };
        Some(View { map, inverse, volume, point, distance, margin, side })
    }

    /// The end of a shadow ray to the point `surface` of the unit sphere; `sign` is 1 if the context is outside.
    #[inline]
    fn target(&self, view: &View, surface: DVec3, sign: f64) -> Vec3 {
        let normal = (view.inverse.transpose() * surface).normalize();
        (self.center.as_dvec3() + view.map * surface + normal * (sign * view.margin)).as_vec3()
    }

    /// A sample at the point `surface` of the unit sphere, in direction `wi`; `sign` is 1 if the context is outside.
    #[inline]
    fn at(&self, view: &View, surface: DVec3, wi: Vec3, sign: f64, density: f32) -> LightSample {
        let target = Some(self.target(view, surface, sign));
        LightSample { wi, at: [0.0; 2], target, radiance: self.radiance, density: Density::SolidAngle(density) }
    }

    /// True unless the point at `distance` along `wi` is on the far side, seen from outside through a near side that is not
    /// there.
    pub(super) fn is_nearest(&self, ctx: &LightContext, wi: Vec3, distance: f32) -> bool {
        let Some(view) = self.view(ctx) else { return false };
        let direction = view.inverse * wi.as_dvec3();
        view.side != Side::Outside || view.is_near(direction, distance)
    }

    /// Of the image of a sphere under a similarity, within the rounding of its axes.
    #[inline]
    pub(crate) fn radius(&self) -> Option<f32> {
        let [x, y, z] = self.axes.map(|a| a.as_dvec3());
        let squared = (x.length_squared() + y.length_squared() + z.length_squared()) / 3.0;
        let off = [x.dot(y), y.dot(z), z.dot(x), x.length_squared() - squared, y.length_squared() - squared];
        off.iter().all(|off| off.abs() <= 1e-6 * squared).then_some(squared.sqrt() as f32)
    }

    /// From a point inside along the unit vector `direction` of the sphere's space: where it meets the far side.
    #[inline]
    fn far_side(view: &View, direction: DVec3) -> DVec3 {
        let along = view.point.dot(direction);
        // Not positive but for rounding.
        let constant = ((view.distance - 1.0) * (view.distance + 1.0)).min(0.0);
        let root = (along * along - constant).sqrt();
        let length = if along > 0.0 { -constant / (along + root) } else { root - along };
        (view.point + direction * length).normalize()
    }

    /// From a point outside: the near side. A ray that just misses the sphere meets where it passes closest.
    #[inline]
    fn near_side(view: &View, direction: DVec3) -> DVec3 {
        let along = -view.point.dot(direction);
        let missed = (view.point + direction * along).length_squared();
        let root = (1.0 - missed).max(0.0).sqrt();
        let length = (view.distance - 1.0) * (view.distance + 1.0) / (along + root);
        (view.point + direction * length).normalize()
    }

    /// The light as a ball, where it is one and projected solid angle serves.
    #[inline]
    fn ball(&self, ctx: &LightContext) -> Option<BallView> {
        let radius = self.radius()?;
        let view = BallView::new(self.center, radius, ctx);
        (view.is_usable && !ctx.transmits).then_some(view)
    }

    #[inline]
    fn sample_outside(&self, view: &View, u: [f32; 2]) -> Option<LightSample> {
        let distance = view.distance;
        let cone = Cone::new(distance);
        let versine = f64::from(u[0]) * cone.versine;
        let (cos, sin2) = (1.0 - versine, versine * (2.0 - versine));
        let sin = sin2.sqrt();
        // From the near root of the ray and the sphere, and the law of sines at the centre.
        let root = (1.0 - sin2 / cone.sin2).max(0.0).sqrt();
        let length = (distance - 1.0) * (distance + 1.0) / (distance * cos + root);
        let sin_center = (length * sin).min(1.0);
        let cos_center = ((1.0 - sin_center) * (1.0 + sin_center)).sqrt();
        let axis = view.point / distance;
        let frame = Frame::from_normal(axis.as_vec3());
        let (sin_phi, cos_phi) = sin_cos_turns(u[1]);
        let tangent = (frame.s * cos_phi + frame.t * sin_phi).as_dvec3();
        let direction = view.map * (tangent * sin - axis * cos).normalize();
        let stretch = direction.length();
        let density = finite_density(stretch * stretch * stretch / (2.0 * PI * cone.versine * view.volume))?;
        let surface = (tangent * sin_center + axis * cos_center).normalize();
        Some(self.at(view, surface, (direction / stretch).as_vec3(), 1.0, density))
    }

    #[inline]
    fn sample_inside(&self, ctx: &LightContext, view: &View, u: [f32; 2]) -> Option<LightSample> {
        let (wi, density) = environment::sample_direction(ctx, u)?;
        let direction = (view.inverse * wi.as_dvec3()).normalize();
        if view.side == Side::On && view.point.dot(direction) >= 0.0 {
            return None;
        }
        Some(self.at(view, Self::far_side(view, direction), wi, -1.0, density))
    }
}

/// A sphere as seen from outside, by projected solid angle. Its functions have no branches but for spheres whose middle is below the
/// horizon, so that loops over many become vector code.
#[derive(Clone, Copy)]
pub(crate) struct BallView {
    cap: ProjectedCap,
    center: DVec3,
    radius: f64,
    /// From the centre to the context, over the radius, and its length.
    point: DVec3,
    distance: f64,
    margin: f64,
    /// True if the context is outside and projected solid angle serves; else nothing is known of the light.
    pub is_usable: bool,
}

impl BallView {
    /// For contexts that do not transmit.
    #[inline(always)]
    pub fn new(center: Vec3, radius: f32, ctx: &LightContext) -> Self {
        let (center, world, radius) = (center.as_dvec3(), ctx.point.as_dvec3(), f64::from(radius));
        let apart = world - center;
        let point = apart / radius;
        let distance = point.length();
        let extent = 3.0 * radius;
        let margin = margin(larger(max_abs(world), max_abs(center) + extent), max_abs(apart) + extent);
        let normal = ctx.normal.as_dvec3();
        let length = normal.length();
        let (cap, serves) = ProjectedCap::look(-point / distance, 1.0 / distance, normal / length);
        let is_usable = serves & ((distance - 1.0) * radius > margin) & (length > 0.0) & (radius > 0.0);
        Self { cap, center, radius, point, distance, margin, is_usable }
    }

    /// True if [`Self::sample_up`] is enough.
    #[inline(always)]
    pub fn is_up(&self) -> bool {
        self.cap.is_up
    }

    /// The point for `u` in [0, 1)^2. Only if the middle is above the horizon.
    #[inline(always)]
    pub fn sample_up(&self, u: [f32; 2]) -> DrawnPoint {
        self.towards(self.cap.sample_up([f64::from(u[0]), f64::from(u[1])]))
    }

    fn sample(&self, u: [f32; 2]) -> DrawnPoint {
        self.towards(self.cap.sample(u.map(f64::from)))
    }

    /// The near side. A ray that just misses the sphere meets where it passes closest.
    #[inline(always)]
    fn towards(&self, wi: DVec3) -> DrawnPoint {
        let along = -self.point.dot(wi);
        let missed = (self.point + wi * along).length_squared();
        let length = (self.distance - 1.0) * (self.distance + 1.0) / (along + larger(1.0 - missed, 0.0).sqrt());
        let surface = self.point + wi * length;
        let surface = surface / surface.length();
        let target = (self.center + surface * (self.radius + self.margin)).as_vec3();
        // The density is that of the direction as it is rounded.
        let density = self.cap.density(wi.as_vec3().as_dvec3());
        DrawnPoint::new(wi, target, [0.0; 2], density)
    }

    fn is_near(&self, wi: Vec3, distance: f32) -> bool {
        let wi = wi.as_dvec3();
        (self.point * self.radius + wi * f64::from(distance)).dot(wi) <= 0.0
    }

    fn pdf(&self, wi: Vec3) -> f32 {
        finite_density(self.cap.density(wi.as_dvec3())).unwrap_or(0.0)
    }
}

impl Emitter for SphereLight {
    #[inline]
    fn radiance(&self) -> Spectrum {
        self.radiance
    }

    /// Exact for spheres; for ellipsoids, an upper bound of the area that is off by a few percent at most for
    /// moderate stretching: only the choice of lights depends on it.
    fn etendue(&self, _scene_radius: f64) -> f64 {
        let map = self.map();
        if map.determinant() == 0.0 {
            return 0.0;
        }
        // The area element at s is |cofactor(A) s|; its root mean square over the sphere.
        let (x, y, z) = (map.x_axis, map.y_axis, map.z_axis);
        let cofactors = x.cross(y).length_squared() + y.cross(z).length_squared() + z.cross(x).length_squared();
        let area = 4.0 * PI * (cofactors / 3.0).sqrt();
        PI * area * if self.two_sided { 2.0 } else { 1.0 }
    }

    #[inline]
    fn sample(&self, ctx: &LightContext, u: [f32; 2]) -> Option<LightSample> {
        if let Some(ball) = self.ball(ctx) {
            return ball.sample(u).sample(self.radiance);
        }
        let view = self.view(ctx)?;
        match view.side {
            Side::Outside => self.sample_outside(&view, u),
            Side::On | Side::Inside => self.sample_inside(ctx, &view, u),
        }
    }

    /// From outside: a direction d of the unit sphere's space becomes A d / |A d|, and solid angles grow by
    /// |det A| / |A d|^3 (the cone of height 1 over a small patch keeps its volume up to |det A|, and has the volume
    /// length^3 / 3 times the solid angle). In terms of the world's unit vector, |A d| = 1 / |A^-1 wi|.
    #[inline]
    fn pdf(&self, ctx: &LightContext, wi: Vec3, distance: f32) -> f32 {
        if let Some(ball) = self.ball(ctx) {
            return if ball.is_near(wi, distance) { ball.pdf(wi) } else { 0.0 };
        }
        let Some(view) = self.view(ctx) else { return 0.0 };
        if view.side != Side::Outside {
            return environment::direction_pdf(ctx, wi);
        }
        let direction = view.inverse * wi.as_dvec3();
        if !view.is_near(direction, distance) {
            return 0.0; // the far side, through a near side that is not there
        }
        let squeeze = direction.length();
        let solid_angle = 2.0 * PI * Cone::new(view.distance).versine;
        finite_density(1.0 / (solid_angle * view.volume * squeeze * squeeze * squeeze)).unwrap_or(0.0)
    }

    /// From inside the sphere is all around. From outside an ellipsoid's outline is no circle: it is left to the lobe.
    fn arcs(&self, circle: &LightCircle) -> Arcs {
        match self.view(&circle.context()) {
            Some(view) if view.side == Side::Inside => Arcs::half(),
            Some(view) if view.side == Side::Outside && self.radius().is_some() => {
                let axis = (self.center.as_dvec3() - circle.point.as_dvec3()).normalize();
                circle.arcs_of_cone(axis, Cone::new(view.distance).versine)
            }
            _ => Arcs::default(),
        }
    }

    fn reach(&self, circle: &LightCircle, phi: f64) -> Option<Reached> {
        let view = self.view(&circle.context())?;
        let direction = (view.inverse * circle.direction(phi)).normalize();
        let (surface, sign) = match view.side {
            Side::Outside => (Self::near_side(&view, direction), 1.0),
            Side::On | Side::Inside => (Self::far_side(&view, direction), -1.0),
        };
        surface.is_finite().then(|| Reached { target: self.target(&view, surface, sign), at: [0.0; 2] })
    }
}
