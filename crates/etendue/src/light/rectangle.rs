//! Emissive rectangles and parallelograms.

use super::{
    Arcs, Emitter, LightCircle, LightContext, LightSample, Reached, between,
    bilinear::{Bilinear, LEAST_COSINE},
    circle::edge_planes,
    finite_density, larger, margin, max_abs,
    patch::Patch,
    planar::{DrawnPoint, Facing},
    spherical::{SphericalTriangle, Warped},
};
use crate::{
    math::{DVec3, Vec3, atan2_wide, dvec3, sin_cos_wide},
    spectrum::Spectrum,
};
use std::f64::consts::PI;

/// An emissive parallelogram `corner + a u + b v`, a, b in [0, 1], sampled by what its points bring where it is not near
/// (`Patch`), else by solid angle: a rectangle by the continuous map of Ureña, Fajardo and King, anything else as two spherical
/// triangles. Where light is gathered on one side of a surface, the cosine at the corners makes it nearly projected solid angle.
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

/// The triangles on either side of the diagonal from the corner, and the corners around, relative to the context.
struct TrianglePair {
    corners: [DVec3; 4],
    triangles: [Warped; 2],
    /// Integral of the value at their points over solid angle.
    total: f64,
}

impl RectangleLight {
    /// What stands in for the map of rectangles where the light is none, or too small for it: relative to a context that
    /// sees the light.
    fn pair(&self, ctx: &LightContext) -> TrianglePair {
        let (corner, u, v) = (self.corner.as_dvec3(), self.u.as_dvec3(), self.v.as_dvec3());
        let (relative, cross) = (corner - ctx.point.as_dvec3(), u.cross(v));
        let corners = [relative, relative + u, relative + u + v, relative + v];
        let [p, q, r, s] = corners;
        // The diagonal is the same edge of both, along which both have the same values.
        let triangles = [[p, q, r], [p, s, r]].map(|c| SphericalTriangle::new(c, cross).warped(ctx));
        let total = triangles[0].total() + triangles[1].total();
        TrianglePair { corners, triangles, total }
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
        PI * area * if self.two_sided { 2.0 } else { 1.0 }
    }

    #[inline]
    fn sample(&self, ctx: &LightContext, u: [f32; 2]) -> Option<LightSample> {
        let frame = RectangleFrame::of(self);
        let view = frame.view::<false>(ctx);
        if !view.is_seen {
            return None;
        }
        if view.is_patch {
            return view.sample_patch(u).sample(self.radiance);
        }
        let map = frame.map(&view);
        let drawn = if map.is_accurate {
            frame.sample_map(&view, &map, u)
        } else {
            let (offset, at, density) = self.pair(ctx).sample(u.map(f64::from));
            view.draw(offset, at, density)
        };
        drawn.sample(self.radiance)
    }

    #[inline]
    fn pdf(&self, ctx: &LightContext, wi: Vec3, _distance: f32) -> f32 {
        let frame = RectangleFrame::of(self);
        let view = frame.view::<false>(ctx);
        if !view.is_seen {
            return 0.0;
        }
        let density = if view.is_patch {
            view.patch_pdf(wi)
        } else {
            let map = frame.map(&view);
            if map.is_accurate { map.pdf(frame.along_axes(wi)) } else { self.pair(ctx).pdf(wi) }
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
    /// The point, its multiples of the edges, and its density. The first number chooses the triangle and is stretched for use inside
    /// it.
    #[inline]
    fn sample(&self, [u, v]: [f64; 2]) -> (DVec3, [f64; 2], f64) {
        let [first, second] = &self.triangles;
        let [p, q, r, s] = self.corners;
        let reached = u * self.total;
        if reached < first.total() {
            let (w, value) = first.sample([reached / first.total(), v]);
            (w[0] * p + w[1] * q + w[2] * r, [w[1] + w[2], w[2]], value / self.total)
        } else {
            let rest = ((reached - first.total()) / second.total()).clamp(0.0, 1.0);
            let (w, value) = second.sample([rest, v]);
            (w[0] * p + w[1] * s + w[2] * r, [w[2], w[1] + w[2]], value / self.total)
        }
    }

    /// Density per solid angle in direction of the unit vector `wi`, which meets one of the triangles.
    fn pdf(&self, wi: Vec3) -> f64 {
        let wi = wi.as_dvec3();
        let [p, q, r, _] = self.corners;
        let diagonal = p.cross(r);
        let is_first = diagonal.dot(wi) * diagonal.dot(q) >= 0.0;
        self.triangles[usize::from(!is_first)].value(wi) / self.total
    }
}

/// All that does not depend on where a [`RectangleLight`] is seen from, and its map (Ureña, Fajardo and King, "An
/// Area-Preserving Parametrization for Spherical Rectangles", 2013).
///
/// In a frame along the edges, at distance z from the plane, the part of the sphere below the quadrant left and below of
/// (x, y) has the solid angle A(x, y) = arg(|z| sqrt(x^2 + y^2 + z^2) + i x y), up to terms of x or y alone. So the strip
/// up to x has, up to a constant, phi(x) = A(x, y1) - A(x, y0), and inverting it gives
/// x = |z| sin(phi) / sqrt((cos(phi) - b0 b1)^2 - (1 - b0^2)(1 - b1^2)), with b = y / sqrt(y^2 + z^2).
/// Angles are added as products of complex numbers, so that one arc tangent is enough.
///
/// Its functions have no branches, so that loops over many points become vector code.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RectangleFrame {
    corner: DVec3,
    u: DVec3,
    v: DVec3,
    x_axis: DVec3,
    y_axis: DVec3,
    /// The front's normal.
    z_axis: DVec3,
    width: f64,
    height: f64,
    /// Bounds of the corners, and the largest magnitude of a coordinate.
    low: DVec3,
    high: DVec3,
    largest: f64,
    /// False for other parallelograms.
    is_rectangle: bool,
    two_sided: bool,
}

/// A parallelogram as seen from a point.
#[derive(Clone, Copy)]
pub(crate) struct RectangleView {
    point: DVec3,
    /// The corner, relative to the point.
    relative: DVec3,
    /// Of the corner along the front's normal.
    z: f64,
    corners: Corners,
    patch: Patch,
    /// True if the light is far enough to be sampled as a patch.
    pub is_patch: bool,
    /// The normal on the point's side, times the margin: what lifts targets off the light.
    lift: DVec3,
    /// True if the point is on an emitting side, farther from the plane than the margin.
    pub is_seen: bool,
}

/// The map of a rectangle as seen from a point.
#[derive(Clone, Copy)]
pub(crate) struct RectangleMap {
    /// What the corners bring, per solid angle.
    weights: Bilinear,
    /// The edges' coordinates in the rectangle's frame, relative to the point.
    x: [f64; 2],
    y: [f64; 2],
    z: f64,
    /// Cosine and sine of phi at x0, times any length.
    phi0: [f64; 2],
    /// Steradians, in [0, 2 pi].
    solid_angle: f64,
    /// False where two triangles are to be taken for the light.
    pub is_accurate: bool,
}

impl RectangleFrame {
    /// True if it has a map at all, which other parallelograms have not.
    #[inline]
    pub fn has_map(&self) -> bool {
        self.is_rectangle
    }

    #[inline]
    pub fn of(light: &RectangleLight) -> Self {
        Self::new([light.corner, light.u, light.v], light.two_sided)
    }

    /// From the corner and the edges.
    #[inline(always)]
    pub fn new([corner, u, v]: [Vec3; 3], two_sided: bool) -> Self {
        let (corner, u, v) = (corner.as_dvec3(), u.as_dvec3(), v.as_dvec3());
        let corners = [corner, corner + u, corner + v, corner + u + v];
        let width = u.length();
        let x_axis = u / width;
        let across = v - x_axis * x_axis.dot(v);
        let height = across.length();
        let y_axis = across / height;
        let cosine = u.dot(v).abs() / (width * v.length());
        Self {
            corner,
            u,
            v,
            x_axis,
            y_axis,
            z_axis: x_axis.cross(y_axis),
            width,
            height,
            low: corners[0].min(corners[1]).min(corners[2]).min(corners[3]),
            high: corners[0].max(corners[1]).max(corners[2]).max(corners[3]),
            largest: larger(
                larger(max_abs(corners[0]), max_abs(corners[1])),
                larger(max_abs(corners[2]), max_abs(corners[3])),
            ),
            is_rectangle: cosine <= RIGHT_ANGLE,
            two_sided,
        }
    }

    /// The rectangle from a point. `ONE_SIDED` promises that light is gathered on one side of a surface.
    #[inline(always)]
    pub fn view<const ONE_SIDED: bool>(&self, ctx: &LightContext) -> RectangleView {
        let point = ctx.point.as_dvec3();
        let relative = self.corner - point;
        let z = relative.dot(self.z_axis);
        let farthest = (self.high - point).abs().max((point - self.low).abs());
        let margin = margin(larger(max_abs(point), self.largest), max_abs(farthest));
        let (patch, is_far) = Patch::parallelogram(z.abs(), relative, self.u, self.v);
        let corners = Corners::new::<ONE_SIDED>(ctx, relative, self.u, self.v);
        RectangleView {
            point,
            relative,
            z,
            corners,
            patch,
            is_patch: is_far & corners.is_lit(),
            lift: self.z_axis * margin.copysign(-z),
            is_seen: (-z > margin) | (self.two_sided & (z > margin)),
        }
    }

    /// What is to be known to sample it by solid angle.
    #[inline(always)]
    pub fn map(&self, view: &RectangleView) -> RectangleMap {
        let RectangleView { relative, z, .. } = *view;
        let (x0, y0) = (relative.dot(self.x_axis), relative.dot(self.y_axis));
        let (x1, y1) = (x0 + self.width, y0 + self.height);
        let phi0 = divide(corner_angle(x0, y1, z), corner_angle(x0, y0, z));
        let phi1 = divide(corner_angle(x1, y1, z), corner_angle(x1, y0, z));
        let [re, im] = divide(phi1, phi0);
        let angle = atan2_wide(im, re);
        let solid_angle = if angle < 0.0 { angle + 2.0 * PI } else { angle };
        RectangleMap {
            weights: view.corners.per_solid_angle(),
            x: [x0, x1],
            y: [y0, y1],
            z,
            phi0,
            solid_angle,
            is_accurate: self.is_rectangle & (solid_angle >= SMALLEST_RECTANGLE),
        }
    }

    /// The coordinates of a direction along the edges and the normal.
    #[inline]
    fn along_axes(&self, wi: Vec3) -> DVec3 {
        let wi = wi.as_dvec3();
        dvec3(wi.dot(self.x_axis), wi.dot(self.y_axis), wi.dot(self.z_axis))
    }

    /// The point for `u` in [0, 1)^2 by the map.
    #[inline(always)]
    pub fn sample_map(&self, view: &RectangleView, map: &RectangleMap, u: [f32; 2]) -> DrawnPoint {
        let u = map.weights.sample([f64::from(u[0]), f64::from(u[1])]);
        let (offset, at) = self.point_of(map, u);
        view.draw(offset, at, map.weights.density(u) * (1.0 / map.solid_angle))
    }

    /// The point that is uniform in solid angle for uniform `u` in [0, 1)^2, and its multiples of the edges.
    #[inline(always)]
    fn point_of(&self, map: &RectangleMap, [u, v]: [f64; 2]) -> (DVec3, [f64; 2]) {
        let ([x0, x1], [y0, y1], z) = (map.x, map.y, map.z);
        let (step_sin, step_cos) = sin_cos_wide(u * map.solid_angle);
        let scale = 1.0 / (map.phi0[0] * map.phi0[0] + map.phi0[1] * map.phi0[1]).sqrt();
        let (cos0, sin0) = (map.phi0[0] * scale, map.phi0[1] * scale);
        let cos = cos0 * step_cos - sin0 * step_sin;
        let sin = sin0 * step_cos + cos0 * step_sin;
        let cosine_to = |y: f64| {
            let square = y * y + z * z;
            (y / square.sqrt(), z * z / square)
        };
        let ((b0, rest0), (b1, rest1)) = (cosine_to(y0), cosine_to(y1));
        let square = (cos - b0 * b1) * (cos - b0 * b1) - rest0 * rest1;
        let x = between(z.abs() * sin / larger(square, f64::MIN_POSITIVE).sqrt(), x0, x1);
        // Along y the arc's measure is the sine of the elevation over the xz plane.
        let squared = x * x + z * z;
        let sine_of = |y: f64| y / (squared + y * y).sqrt();
        let (h0, h1) = (sine_of(y0), sine_of(y1));
        let h = h0 + v * (h1 - h0);
        let y = h * (squared / larger((1.0 - h) * (1.0 + h), f64::MIN_POSITIVE)).sqrt();
        let y = between(y, y0, y1);
        let offset = x * self.x_axis + y * self.y_axis + z * self.z_axis;
        (offset, [(x - x0) / self.width, (y - y0) / self.height])
    }
}

impl RectangleView {
    /// The point for `u` in [0, 1)^2 as a patch.
    #[inline(always)]
    pub fn sample_patch(&self, u: [f32; 2]) -> DrawnPoint {
        let weights = self.corners.per_area();
        let at = weights.sample([f64::from(u[0]), f64::from(u[1])]);
        let point = self.patch.point(at);
        self.draw(point.offset, at, weights.density(at) * point.even)
    }

    /// Density of a patch per solid angle in direction of the unit vector `wi`, which meets the light.
    #[inline]
    fn patch_pdf(&self, wi: Vec3) -> f64 {
        let (at, even) = self.patch.towards(wi);
        let density = self.corners.per_area().density(at) * even;
        if density.is_finite() { density } else { 0.0 }
    }

    /// The point at `offset` from the context, `at` these multiples of the edges.
    #[inline(always)]
    fn draw(&self, offset: DVec3, at: [f64; 2], density: f64) -> DrawnPoint {
        DrawnPoint::new(offset, (self.point + offset + self.lift).as_vec3(), at, density)
    }
}

impl RectangleMap {
    /// Density per solid angle in direction of the unit vector `wi`, in the rectangle's frame, which meets the light.
    #[inline]
    fn pdf(&self, wi: DVec3) -> f64 {
        self.weights.density(self.locate(wi)) / self.solid_angle
    }

    /// The numbers for which [`RectangleFrame::point_of`] goes towards `wi`, in the rectangle's frame, which meets the light.
    fn locate(&self, wi: DVec3) -> [f64; 2] {
        let ([x0, x1], [y0, y1], z) = (self.x, self.y, self.z);
        let (x, y) = (between(wi.x * z / wi.z, x0, x1), between(wi.y * z / wi.z, y0, y1));
        let phi = divide(corner_angle(x, y1, z), corner_angle(x, y0, z));
        let [re, im] = divide(phi, self.phi0);
        let angle = atan2_wide(im, re);
        // Below 0 by rounding, or beyond a half turn.
        let turned = angle + 2.0 * PI;
        let angle = if angle < 0.0 && turned - self.solid_angle < -angle { turned } else { angle };
        let squared = x * x + z * z;
        let sine_of = |y: f64| y / (squared + y * y).sqrt();
        let (h0, h1) = (sine_of(y0), sine_of(y1));
        [between(angle / self.solid_angle, 0.0, 1.0), between((sine_of(y) - h0) / (h1 - h0), 0.0, 1.0)]
    }
}

/// A complex number whose angle is the difference of two numbers' angles.
#[inline(always)]
fn divide([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c + b * d, b * c - a * d]
}

/// A complex number, of any length, whose angle is A(x, y) in the words of [`RectangleFrame`]; where a product leaves the range of
/// f64, the angle is no number or 0.
#[inline(always)]
fn corner_angle(x: f64, y: f64, z: f64) -> [f64; 2] {
    [z.abs() * (x * x + y * y + z * z).sqrt(), x * y]
}

/// What the corners of a parallelogram bring to a context.
#[derive(Clone, Copy)]
struct Corners {
    /// Of each the cosine at the context times the distance, or the distance where nothing is known of the cosine.
    cosines: [f64; 4],
    /// Of each the square of the distance.
    squares: [f64; 4],
}

impl Corners {
    /// `corner` is relative to the context. `ONE_SIDED` promises that light is gathered on one side of a surface.
    #[inline(always)]
    fn new<const ONE_SIDED: bool>(ctx: &LightContext, corner: DVec3, u: DVec3, v: DVec3) -> Self {
        let normal = ctx.normal.as_dvec3();
        // On both sides or in a medium nothing is known of the cosine.
        let any = !ONE_SIDED && (ctx.transmits | (normal.length_squared() == 0.0));
        let measure = |c: DVec3| {
            let square = c.length_squared();
            (if any { square.sqrt() } else { larger(c.dot(normal), 0.0) }, square)
        };
        let (c00, s00) = measure(corner);
        let (c10, s10) = measure(corner + u);
        let (c01, s01) = measure(corner + v);
        let (c11, s11) = measure(corner + u + v);
        Self { cosines: [c00, c10, c01, c11], squares: [s00, s10, s01, s11] }
    }

    /// True if any is above the horizon.
    #[inline(always)]
    fn is_lit(&self) -> bool {
        let [c00, c10, c01, c11] = self.cosines;
        larger(larger(c00, c10), larger(c01, c11)) > 0.0
    }

    /// Per area, if any is lit.
    #[inline(always)]
    fn per_area(&self) -> Bilinear {
        let ([c00, c10, c01, c11], [s00, s10, s01, s11]) = (self.cosines, self.squares);
        Bilinear::new([c00 / (s00 * s00), c10 / (s10 * s10), c01 / (s01 * s01), c11 / (s11 * s11)], 0.0)
    }

    /// Per solid angle.
    #[inline(always)]
    fn per_solid_angle(&self) -> Bilinear {
        let ([c00, c10, c01, c11], [s00, s10, s01, s11]) = (self.cosines, self.squares);
        let values = [c00 / s00.sqrt(), c10 / s10.sqrt(), c01 / s01.sqrt(), c11 / s11.sqrt()];
        Bilinear::new(values, LEAST_COSINE)
    }
}
