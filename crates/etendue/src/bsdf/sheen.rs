//! A lobe of upright fibres, bright at grazing angles: cloth (Estevez and Kulla, "Production Friendly Microfacet Sheen
//! BRDF", 2017), with the shadowing of Neubelt and Pettineo ("Crafting a Next-Gen Material Pipeline for The Order: 1886",
//! 2013).
//!
//! D(m) = (2 + 1/alpha) sin(theta_m)^(1/alpha) / (2 pi), f = D / (4 (z_o + z_i - z_o z_i)).

use super::ggx;
use crate::math::{PI, Vec3, pow};

/// Narrower lobes are widened to this: they are seen at grazing angles only, and scatter more than arrives.
pub const ALPHA_MIN: f32 = 0.05;

/// f cos_i for directions with z > 0, before it is scaled to lose energy nowhere: see [`ceiling`].
#[inline]
pub fn lobe(wo: Vec3, wi: Vec3, alpha: f32) -> f32 {
    let (m, true) = ggx::half_vector(wo, wi) else { return 0.0 };
    let exponent = 1.0 / alpha;
    let sin2 = m.x * m.x + m.y * m.y;
    let density = (2.0 + exponent) * (0.5 / PI) * pow(sin2, 0.5 * exponent);
    density * wi.z / (4.0 * (wo.z + wi.z - wo.z * wi.z))
}

/// Factor of the lobe for two directions where it has these albedos, that keeps every albedo at most 1, the same there and
/// back.
#[inline]
pub fn ceiling(albedo_o: f32, albedo_i: f32) -> f32 {
    1.0 / albedo_o.max(albedo_i).max(1.0)
}
