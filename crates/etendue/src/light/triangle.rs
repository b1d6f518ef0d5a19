//! Emissive triangles.

use super::{
    Arcs, Emitter, LightCircle, LightContext, LightSample, Reached, circle::edge_planes, finite_density, patch::Patch,
    planar::Facing, spherical::SphericalTriangle,
};
use crate::{
    math::{DVec3, Vec3},
    spectrum::Spectrum,
};

/// An emissive triangle, sampled uniformly in solid angle, or from afar, where that is nearly the same, by area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleLight {
    /// Metres; the front is where they turn counter-clockwise.
    pub vertices: [Vec3; 3],
    /// W sr^-1 m^-2.
    pub radiance: Spectrum,
    /// Emits from the back too.
    pub two_sided: bool,
}

/// How the light looks from a context.
enum View {
    Patch(Patch),
    /// With the vertices relative to the context.
    Spherical(SphericalTriangle, [DVec3; 3]),
}

impl TriangleLight {
    #[inline]
    fn cross([a, b, c]: [DVec3; 3]) -> DVec3 {
        (b - a).cross(c - a)
    }

    #[inline]
    fn view(&self, ctx: &LightContext) -> Option<(Facing, View)> {
        let vertices = self.vertices.map(|v| v.as_dvec3());
        let cross = Self::cross(vertices);
        let facing = Facing::new(ctx, &vertices, cross, self.two_sided)?;
        let point = ctx.point.as_dvec3();
        let relative = vertices.map(|v| v - point);
        let [a, b, c] = relative;
        let view = match Patch::triangle(&facing, a, b - a, c - a) {
            Some(patch) => View::Patch(patch),
            None => View::Spherical(SphericalTriangle::new(relative, cross), relative),
        };
        Some((facing, view))
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
        let (facing, view) = self.view(ctx)?;
        let u = u.map(f64::from);
        let (offset, at, density) = match view {
            View::Patch(patch) => patch.sample(u),
            View::Spherical(triangle, [a, b, c]) => {
                let w = triangle.sample(u);
                (w[0] * a + w[1] * b + w[2] * c, [w[1], w[2]], 1.0 / triangle.solid_angle)
            }
        };
        facing.sample(offset, at, density, self.radiance)
    }

    #[inline]
    fn pdf(&self, ctx: &LightContext, wi: Vec3, _distance: f32) -> f32 {
        let Some((_, view)) = self.view(ctx) else { return 0.0 };
        let density = match view {
            View::Patch(patch) => patch.pdf(wi),
            View::Spherical(triangle, _) => 1.0 / triangle.solid_angle,
        };
        finite_density(density).unwrap_or(0.0)
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
