//! Emissive rectangles and parallelograms.

use super::{
    Arcs, Emitter, LightCircle, LightContext, LightSample, Reached, circle::edge_planes, finite_density, patch::Patch,
    planar::Facing, spherical::SphericalTriangle,
};
use crate::{
    math::{DVec3, Vec3},
    spectrum::Spectrum,
};

/// An emissive parallelogram `corner + a u + b v`, a, b in [0, 1], sampled by what its points bring where it is not near
/// (`Patch`), else uniformly in solid angle: a rectangle by the continuous map of Ureña, Fajardo and King, anything else as two
/// spherical triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectangleLight {
    /// Metres.
    pub corner: Vec3,
    /// First edge, metres; the front's normal is along `u` x `v`.
    pub u: Vec3,
    /// Second edge, metres.
    pub v: Vec3,
    /// W sr^-1 m^-2.
    pub radiance: Spectrum,
    /// Emits from the back too.
    pub two_sided: bool,
}

/// Edges whose angle's cosine is below this make a rectangle: what f32 rounding leaves of a right angle.
const RIGHT_ANGLE: f64 = 1e-6;

/// Below this solid angle (steradians) the rectangle's map loses more than about 1e-7 of its width to cancellation, and
/// the two triangles, which do not cancel, take over.
const SMALLEST_RECTANGLE: f64 = 1e-8;

/// How the light looks from a context.
enum View {
    Patch(Patch),
    Rectangle(SphericalRectangle),
    Triangles(TrianglePair),
}

/// The triangles (corner, u, u + v) and (corner, u + v, v), and their corners relative to the context.
struct TrianglePair {
    corners: [DVec3; 4],
    triangles: [SphericalTriangle; 2],
}

impl RectangleLight {
    #[inline]
    fn view(&self, ctx: &LightContext) -> Option<(Facing, View)> {
        let (corner, u, v) = (self.corner.as_dvec3(), self.u.as_dvec3(), self.v.as_dvec3());
        let cross = u.cross(v);
        let facing = Facing::new(ctx, &[corner, corner + u, corner + u + v, corner + v], cross, self.two_sided)?;
        let relative = corner - ctx.point.as_dvec3();
        if let Some(patch) = Patch::parallelogram(ctx, &facing, relative, u, v) {
            return Some((facing, View::Patch(patch)));
        }
        if u.dot(v).abs() <= RIGHT_ANGLE * (u.length_squared() * v.length_squared()).sqrt() {
            let rectangle = SphericalRectangle::new(relative, u, v);
            if rectangle.solid_angle >= SMALLEST_RECTANGLE {
                return Some((facing, View::Rectangle(rectangle)));
            }
        }
        let corners = [relative, relative + u, relative + u + v, relative + v];
        let triangles = [
            SphericalTriangle::new([corners[0], corners[1], corners[2]], cross),
            SphericalTriangle::new([corners[0], corners[2], corners[3]], cross),
        ];
        Some((facing, View::Triangles(TrianglePair { corners, triangles })))
    }
}

impl RectangleLight {
    /// Relative to the circle's point: the corner, and the planes through it and the edges at v = 0, u = 1, v = 1, u = 0.
    #[inline]
    fn on_circle(&self, circle: &LightCircle) -> Option<(Facing, DVec3, [DVec3; 4])> {
        let (corner, u, v) = (self.corner.as_dvec3(), self.u.as_dvec3(), self.v.as_dvec3());
        let (cross, corners) = (u.cross(v), [corner, corner + u, corner + u + v, corner + v]);
        let facing = Facing::new(&circle.context(), &corners, cross, self.two_sided)?;
        let relative = corners.map(|c| c - circle.point.as_dvec3());
        Some((facing, relative[0], edge_planes(&relative, cross)))
    }
}

impl Emitter for RectangleLight {
    #[inline]
    fn radiance(&self) -> Spectrum {
        self.radiance
    }

    fn etendue(&self, _scene_radius: f64) -> f64 {
        let area = self.u.as_dvec3().cross(self.v.as_dvec3()).length();
        std::f64::consts::PI * area * if self.two_sided { 2.0 } else { 1.0 }
    }

    #[inline]
    fn sample(&self, ctx: &LightContext, u: [f32; 2]) -> Option<LightSample> {
        let (facing, view) = self.view(ctx)?;
        let u = u.map(f64::from);
        let (offset, at, density) = match view {
            View::Patch(patch) => patch.sample(u),
            View::Rectangle(rectangle) => {
                let (offset, at) = rectangle.sample(u);
                (offset, at, 1.0 / rectangle.solid_angle)
            }
            View::Triangles(pair) => {
                let solid_angle = pair.solid_angle();
                let (offset, at) = pair.sample(u, solid_angle);
                (offset, at, 1.0 / solid_angle)
            }
        };
        facing.sample(offset, at, density, self.radiance)
    }

    #[inline]
    fn pdf(&self, ctx: &LightContext, wi: Vec3, _distance: f32) -> f32 {
        let Some((_, view)) = self.view(ctx) else { return 0.0 };
        let density = match view {
            View::Patch(patch) => patch.pdf(wi),
            View::Rectangle(rectangle) => 1.0 / rectangle.solid_angle,
            View::Triangles(pair) => 1.0 / pair.solid_angle(),
        };
        finite_density(density).unwrap_or(0.0)
    }

    fn arcs(&self, circle: &LightCircle) -> Arcs {
        self.on_circle(circle).map_or_else(Arcs::default, |(_, _, planes)| circle.arcs_of_polygon(&planes))
    }

    /// Between opposite edges the point divides the distance as it does those from their planes.
    fn reach(&self, circle: &LightCircle, phi: f64) -> Option<Reached> {
        let (facing, corner, planes) = self.on_circle(circle)?;
        let direction = circle.direction(phi);
        let [bottom, right, top, left] = planes.map(|plane| plane.dot(direction).max(0.0));
        let at = [left / (left + right), bottom / (bottom + top)];
        let offset = corner + self.u.as_dvec3() * at[0] + self.v.as_dvec3() * at[1];
        offset.is_finite().then(|| Reached { target: facing.target(offset), at: at.map(|a| a as f32) })
    }
}

impl TrianglePair {
    #[inline]
    fn solid_angle(&self) -> f64 {
        self.triangles[0].solid_angle + self.triangles[1].solid_angle
    }

    /// The point and its multiples of the edges. The first number chooses the triangle in proportion to its solid angle
    /// and is stretched for use inside it.
    #[inline]
    fn sample(&self, [u, v]: [f64; 2], solid_angle: f64) -> (DVec3, [f64; 2]) {
        let [first, second] = &self.triangles;
        let [p, q, r, s] = self.corners;
        let reached = u * solid_angle;
        if reached < first.solid_angle {
            let w = first.sample([reached / first.solid_angle, v]);
            (w[0] * p + w[1] * q + w[2] * r, [w[1] + w[2], w[2]])
        } else {
            let rest = ((reached - first.solid_angle) / second.solid_angle).clamp(0.0, 1.0);
            let w = second.sample([rest, v]);
            (w[0] * p + w[1] * r + w[2] * s, [w[1], w[1] + w[2]])
        }
    }
}

/// A rectangle seen from the origin (Ureña, Fajardo and King, "An Area-Preserving Parametrization for Spherical
/// Rectangles", 2013).
///
/// In a frame along the edges, at distance z from the plane, the part of the sphere below the quadrant left and below of
/// (x, y) has the solid angle A(x, y) = arg(|z| sqrt(x^2 + y^2 + z^2) + i x y), up to terms of x or y alone. So the strip
/// up to x has, up to a constant, phi(x) = A(x, y1) - A(x, y0), and inverting it gives
/// x = |z| sin(phi) / sqrt((cos(phi) - b0 b1)^2 - (1 - b0^2)(1 - b1^2)), with b = y / sqrt(y^2 + z^2).
/// Angles are added as products of complex numbers, so that one arc tangent is enough.
struct SphericalRectangle {
    x_axis: DVec3,
    y_axis: DVec3,
    z_axis: DVec3,
    x: [f64; 2],
    y: [f64; 2],
    z: f64,
    /// Cosine and sine of phi at x0, times any length.
    phi0: [f64; 2],
    /// Steradians, in [0, 2 pi].
    solid_angle: f64,
}

impl SphericalRectangle {
    #[inline]
    fn new(corner: DVec3, u: DVec3, v: DVec3) -> Self {
        let width = u.length();
        let x_axis = u / width;
        let v = v - x_axis * x_axis.dot(v);
        let height = v.length();
        let y_axis = v / height;
        let z_axis = x_axis.cross(y_axis);
        let (x0, y0, z) = (corner.dot(x_axis), corner.dot(y_axis), corner.dot(z_axis));
        let (x1, y1) = (x0 + width, y0 + height);
        // Numbers whose angle counts, of any length; where a product leaves the range of f64, the angle is no number or 0.
        let corner_angle = |x: f64, y: f64| [z.abs() * (x * x + y * y + z * z).sqrt(), x * y];
        let phi0 = divide(corner_angle(x0, y1), corner_angle(x0, y0));
        let phi1 = divide(corner_angle(x1, y1), corner_angle(x1, y0));
        let [re, im] = divide(phi1, phi0);
        let angle = libm::atan2(im, re);
        let solid_angle = if angle < 0.0 { angle + 2.0 * std::f64::consts::PI } else { angle };
        Self { x_axis, y_axis, z_axis, x: [x0, x1], y: [y0, y1], z, phi0, solid_angle }
    }

    /// The point, relative to the origin, that is uniform in solid angle for uniform `u` in [0, 1)^2, and its multiples of
    /// the edges.
    #[inline]
    fn sample(&self, [u, v]: [f64; 2]) -> (DVec3, [f64; 2]) {
        let ([x0, x1], [y0, y1], z) = (self.x, self.y, self.z);
        let (step_sin, step_cos) = libm::sincos(u * self.solid_angle);
        let scale = 1.0 / (self.phi0[0] * self.phi0[0] + self.phi0[1] * self.phi0[1]).sqrt();
        let [cos0, sin0] = self.phi0.map(|p| p * scale);
        let cos = cos0 * step_cos - sin0 * step_sin;
        let sin = sin0 * step_cos + cos0 * step_sin;
        let cosine_to = |y: f64| {
            let square = y * y + z * z;
            (y / square.sqrt(), z * z / square)
        };
        let ((b0, rest0), (b1, rest1)) = (cosine_to(y0), cosine_to(y1));
        let square = (cos - b0 * b1) * (cos - b0 * b1) - rest0 * rest1;
        let x = z.abs() * sin / square.max(f64::MIN_POSITIVE).sqrt();
        let x = x.clamp(x0, x1);
        // Along y the arc's measure is the sine of the elevation over the xz plane.
        let distance = (x * x + z * z).sqrt();
        let sine_of = |y: f64| y / (distance * distance + y * y).sqrt();
        let (h0, h1) = (sine_of(y0), sine_of(y1));
        let h = h0 + v * (h1 - h0);
        let y = h * distance / ((1.0 - h) * (1.0 + h)).max(f64::MIN_POSITIVE).sqrt();
        let y = y.clamp(y0, y1);
        (x * self.x_axis + y * self.y_axis + z * self.z_axis, [(x - x0) / (x1 - x0), (y - y0) / (y1 - y0)])
    }
}

/// A complex number whose angle is the difference of two numbers' angles.
#[inline]
fn divide([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c + b * d, b * c - a * d]
}
