//! Emissive triangles.

use super::{
    Arcs, Emitter, LightCircle, LightContext, LightSample, Reached,
    circle::edge_planes,
    finite_density,
    patch::Patch,
    planar::{DrawnPoint, Facing},
    spherical::{SphericalTriangle, Warped},
};
use crate::{
    math::{DVec3, Vec3, vec3},
    spectrum::Spectrum,
};

/// An emissive triangle, sampled by solid angle, nearly by projected solid angle where light is gathered on one side of a surface, or
/// from afar, where that is nearly the same, by area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleLight {
    /// Metres; the front is where they turn counter-clockwise.
    pub vertices: [Vec3; 3],
    /// W sr^-1 m^-2.
    pub radiance: Spectrum,
    /// Emits from the back too.
    pub two_sided: bool,
}

/// A triangle as seen from a context. Its functions have no branches, so that loops over many become vector code.
#[derive(Clone, Copy)]
pub(crate) struct TriangleView {
    facing: Facing,
    /// True if the context sees an emitting side, and is farther from the plane than the margin.
    pub is_seen: bool,
    patch: Patch,
    /// True if the light is far enough to be sampled as a patch.
    is_patch: bool,
    /// The corners relative to the context.
    relative: [DVec3; 3],
    cross: DVec3,
}

impl TriangleView {
    #[inline(always)]
    pub fn new(vertices: [Vec3; 3], two_sided: bool, ctx: &LightContext) -> Self {
        let vertices = [vertices[0].as_dvec3(), vertices[1].as_dvec3(), vertices[2].as_dvec3()];
        let cross = TriangleLight::cross(vertices);
        let (facing, is_seen) = Facing::look(ctx, &vertices, cross, two_sided);
        let point = ctx.point.as_dvec3();
        let relative = [vertices[0] - point, vertices[1] - point, vertices[2] - point];
        let [a, b, c] = relative;
        let (patch, is_patch) = Patch::triangle(facing.height(), a, b - a, c - a);
        Self { facing, is_seen, patch, is_patch, relative, cross }
    }

    /// The point for `u` in [0, 1)^2, both ways and then one of them.
    #[inline(always)]
    pub fn sample(&self, ctx: &LightContext, u: [f32; 2]) -> DrawnPoint {
        let (far, near) = (self.sample_patch(u), self.sample_sphere(ctx, u));
        let pick = |far: f32, near: f32| if self.is_patch { far } else { near };
        let pick3 = |far: Vec3, near: Vec3| vec3(pick(far.x, near.x), pick(far.y, near.y), pick(far.z, near.z));
        DrawnPoint {
            wi: pick3(far.wi, near.wi),
            target: pick3(far.target, near.target),
            at: [pick(far.at[0], near.at[0]), pick(far.at[1], near.at[1])],
            density: pick(far.density, near.density),
            is_valid: if self.is_patch { far.is_valid } else { near.is_valid },
        }
    }

    #[inline(always)]
    fn sample_patch(&self, u: [f32; 2]) -> DrawnPoint {
        let root = f64::from(u[0]).sqrt();
        let at = [1.0 - root, f64::from(u[1]) * root];
        let point = self.patch.point(at);
        self.facing.draw(point.offset, at, 2.0 * point.even)
    }

    #[inline(always)]
    fn sample_sphere(&self, ctx: &LightContext, u: [f32; 2]) -> DrawnPoint {
        let (triangle, [a, b, c]) = (self.spherical(ctx), self.relative);
        let (w, value) = triangle.sample([f64::from(u[0]), f64::from(u[1])]);
        self.facing.draw(w[0] * a + w[1] * b + w[2] * c, [w[1], w[2]], value / triangle.total())
    }

    #[inline(always)]
    fn spherical(&self, ctx: &LightContext) -> Warped {
        SphericalTriangle::new(self.relative, self.cross).warped(ctx)
    }

    /// Density per solid angle in direction of the unit vector `wi`, which meets the light.
    #[inline]
    fn pdf(&self, ctx: &LightContext, wi: Vec3) -> f64 {
        if self.is_patch {
            let (_, even) = self.patch.towards(wi);
            return if even.is_finite() { 2.0 * even } else { 0.0 };
        }
        let triangle = self.spherical(ctx);
        triangle.value(wi.as_dvec3()) / triangle.total()
    }
}

impl TriangleLight {
    #[inline(always)]
    fn cross([a, b, c]: [DVec3; 3]) -> DVec3 {
        (b - a).cross(c - a)
    }

    #[inline]
    fn view(&self, ctx: &LightContext) -> Option<TriangleView> {
        let view = TriangleView::new(self.vertices, self.two_sided, ctx);
        view.is_seen.then_some(view)
    }
}

impl TriangleLight {
    /// Relative to the circle's point: the corners, and the planes through it and the edges from each.
    #[inline]
    fn on_circle(&self, circle: &LightCircle) -> Option<(Facing, [DVec3; 3], [DVec3; 3])> {
        let vertices = self.vertices.map(|v| v.as_dvec3());
        let cross = Self::cross(vertices);
        let facing = Facing::new(&circle.context(), &vertices, cross, self.two_sided)?;
        let relative = vertices.map(|v| v - circle.point.as_dvec3());
        Some((facing, relative, edge_planes(&relative, cross)))
    }
}

impl Emitter for TriangleLight {
    #[inline]
    fn radiance(&self) -> Spectrum {
        self.radiance
    }

    fn etendue(&self, _scene_radius: f64) -> f64 {
        let area = 0.5 * Self::cross(self.vertices.map(|v| v.as_dvec3())).length();
        std::f64::consts::PI * area * if self.two_sided { 2.0 } else { 1.0 }
    }

    #[inline]
    fn sample(&self, ctx: &LightContext, u: [f32; 2]) -> Option<LightSample> {
        let view = self.view(ctx)?;
        let drawn = if view.is_patch { view.sample_patch(u) } else { view.sample_sphere(ctx, u) };
        drawn.sample(self.radiance)
    }

    #[inline]
    fn pdf(&self, ctx: &LightContext, wi: Vec3, _distance: f32) -> f32 {
        let Some(view) = self.view(ctx) else { return 0.0 };
        finite_density(view.pdf(ctx, wi)).unwrap_or(0.0)
    }

    fn arcs(&self, circle: &LightCircle) -> Arcs {
        self.on_circle(circle).map_or_else(Arcs::default, |(_, _, planes)| circle.arcs_of_polygon(&planes))
    }

    /// A corner's weight is in proportion to the distance from the plane of the edge across.
    fn reach(&self, circle: &LightCircle, phi: f64) -> Option<Reached> {
        let (facing, [a, b, c], planes) = self.on_circle(circle)?;
        let direction = circle.direction(phi);
        let [wc, wa, wb] = planes.map(|plane| plane.dot(direction).max(0.0));
        let sum = wa + wb + wc;
        let offset = (a * wa + b * wb + c * wc) / sum;
        let at = [(wb / sum) as f32, (wc / sum) as f32];
        offset.is_finite().then(|| Reached { target: facing.target(offset), at })
    }
}
