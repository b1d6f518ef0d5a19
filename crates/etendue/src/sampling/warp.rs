//! Maps from the unit square to directions and points, each with its density beside it. All keep neighbours together, so
//! that the stratification of the numbers carries over. Directions are of unit length, about +z.

use crate::math::{PI, Vec2, Vec3, exp_wide, ln_wide, sin_cos_turns, vec2, vec3};

/// Uniform on the unit disk (Shirley and Chiu, "A Low Distortion Map Between Disk and Square", 1997).
#[inline(always)]
pub fn disk([u, v]: [f32; 2]) -> Vec2 {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let wide = a.abs() > b.abs();
    let (radius, other) = if wide { (a, b) } else { (b, a) };
    // At the centre any angle will do.
    let eighth = if radius == 0.0 { 0.0 } else { other / radius * 0.125 };
    let (sin, cos) = sin_cos_turns(if wide { eighth } else { 0.25 - eighth });
    vec2(radius * cos, radius * sin)
}

/// Density of [`disk`] per area.
pub const DISK_PDF: f32 = 1.0 / PI;

/// Uniform on a triangle, as the weights of its corners, none negative, with the sum 1
/// (Heitz, "A Low-Distortion Map Between Triangle and Square", 2019). The density is one over the area.
#[inline]
pub fn triangle([u, v]: [f32; 2]) -> [f32; 3] {
    let (a, b) = if v > u { (0.5 * u, v - 0.5 * u) } else { (u - 0.5 * v, 0.5 * v) };
    [a, b, (1.0 - a - b).max(0.0)]
}

/// Cosine-distributed.
#[inline(always)]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let d = disk(u);
    vec3(d.x, d.y, (1.0 - d.x * d.x - d.y * d.y).max(0.0).sqrt())
}

/// Density of [`cosine_hemisphere`] per solid angle, `cos_theta` the direction's z.
#[inline(always)]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * (1.0 / PI)
}

/// Distributed as the cosine to the power `exponent` >= 0, as in Phong's lobe
/// (Lafortune and Willems, "Using the Modified Phong Reflectance Model", 1994).
#[inline(always)]
pub fn cosine_power_hemisphere([u, v]: [f32; 2], exponent: f32) -> Vec3 {
    // In f64, because narrow lobes live in the difference of the cosine from 1.
    let cos = exp_wide(ln_wide(1.0 - u) / (f64::from(exponent) + 1.0));
    polar((1.0 - cos * cos).max(0.0).sqrt() as f32, cos as f32, v)
}

/// Density of [`cosine_power_hemisphere`] per solid angle, `cos_theta` the direction's z.
#[inline(always)]
pub fn cosine_power_hemisphere_pdf(cos_theta: f32, exponent: f32) -> f32 {
    let is_above = cos_theta > 0.0;
    let power = exp_wide(ln_wide(if is_above { cos_theta } else { 1.0 }) * f64::from(exponent));
    let density = (power * (f64::from(exponent) + 1.0)) as f32 * (0.5 / PI);
    if is_above { density } else { 0.0 }
}

/// Uniform on the hemisphere z >= 0.
#[inline]
pub fn uniform_hemisphere(u: [f32; 2]) -> Vec3 {
    uniform_cone(u, 1.0)
}

/// Density of [`uniform_hemisphere`] per solid angle.
pub const UNIFORM_HEMISPHERE_PDF: f32 = 0.5 / PI;

/// Uniform on the unit sphere.
#[inline]
pub fn uniform_sphere(u: [f32; 2]) -> Vec3 {
    uniform_cone(u, 2.0)
}

/// Density of [`uniform_sphere`] per solid angle.
pub const UNIFORM_SPHERE_PDF: f32 = 0.25 / PI;

/// Uniform on the cone of directions whose cosine with +z is at least `1 - height`, `height` in (0, 2]. The height, not the
/// cosine, keeps the precision of narrow cones: it is 2 sin^2(angle / 2).
#[inline]
pub fn uniform_cone([u, v]: [f32; 2], height: f32) -> Vec3 {
    let h = u * height;
    polar((h * (2.0 - h)).max(0.0).sqrt(), 1.0 - h, v)
}

/// Density of [`uniform_cone`] per solid angle, inside of the cone.
#[inline]
pub fn uniform_cone_pdf(height: f32) -> f32 {
    0.5 / (PI * height)
}

/// The direction with this polar angle and `turns` of azimuth.
#[inline(always)]
fn polar(sin_theta: f32, cos_theta: f32, turns: f32) -> Vec3 {
    let (sin, cos) = sin_cos_turns(turns);
    vec3(sin_theta * cos, sin_theta * sin, cos_theta)
}
