//! Maps from the unit square to directions and points, each with its density beside it.

use crate::math::{PI, Vec2, Vec3, sin_cos_turns, vec2, vec3};

/// Uniform on the unit disk (Shirley and Chiu, "A Low Distortion Map Between Disk and Square", 1997).
#[inline]
pub fn disk([u, v]: [f32; 2]) -> Vec2 {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a == 0.0 && b == 0.0 {
        return Vec2::ZERO;
    }
    let (radius, turns) = if a.abs() > b.abs() { (a, b / a * 0.125) } else { (b, 0.25 - a / b * 0.125) };
    let (sin, cos) = sin_cos_turns(turns);
    vec2(radius * cos, radius * sin)
}

/// Cosine-distributed about +z; unit length.
#[inline]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let d = disk(u);
    vec3(d.x, d.y, (1.0 - d.x * d.x - d.y * d.y).max(0.0).sqrt())
}

/// Density of [`cosine_hemisphere`] per solid angle, `cos_theta` the direction's z.
#[inline]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * (1.0 / PI)
}

/// Uniform on the unit sphere.
#[inline]
pub fn uniform_sphere([u, v]: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = sin_cos_turns(v);
    vec3(r * cos, r * sin, z)
}

/// Density of [`uniform_sphere`] per solid angle.
pub const UNIFORM_SPHERE_PDF: f32 = 1.0 / (4.0 * PI);
