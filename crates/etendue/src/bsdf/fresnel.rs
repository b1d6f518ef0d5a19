//! Exact Fresnel reflectance of unpolarised light (Born and Wolf, "Principles of Optics", 1.5 and 14.2), in forms that
//! lose no digits at grazing angles.

use crate::{math::Vec3, spectrum::Spectrum};

/// What happens at a smooth dielectric interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Reflected share of the energy, in [0, 1]; 1 under total internal reflection.
    pub reflectance: f32,
    /// Cosine between the refracted direction and the normal on its side; 0 under total internal reflection.
    pub cos_t: f32,
}

/// Meets an interface at `cos_i` in [0, 1] (values above 1 by rounding are taken as 1). `eta` > 0 is the index beyond the
/// interface over that on the side of the ray.
#[inline(always)]
pub fn dielectric(cos_i: f32, eta: f32) -> Interface {
    let cos_i = cos_i.min(1.0);
    // Snell's law: eta^2 cos_t^2 = eta^2 - sin_i^2. Without a difference of squares near 1, exact also for eta near 1.
    let scaled = (eta - 1.0) * (eta + 1.0) + cos_i * cos_i;
    let passes = (scaled > 0.0) & (cos_i > 0.0);
    let root = if passes { scaled } else { 0.0 }.sqrt();
    let cos_t = (root / eta).min(1.0);
    let perpendicular = (cos_i - root) / (cos_i + root);
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let reflectance = (0.5 * (perpendicular * perpendicular + parallel * parallel)).min(1.0);
    Interface { reflectance: if passes { reflectance } else { 1.0 }, cos_t: if passes { cos_t } else { 0.0 } }
}

/// Transmitted share of the energy between two directions of refraction: `cos_i` and `cos_t`, above 0, are their cosines with
/// the normal on their own sides, `eta` the index on the side of `cos_t` over that on the other. The same there and back to
/// the last digits, where 1 less the reflectance would have few left.
#[inline(always)]
pub fn transmittance(cos_i: f32, cos_t: f32, eta: f32) -> f32 {
    let perpendicular = cos_i + eta * cos_t;
    let parallel = eta * cos_i + cos_t;
    let product = 2.0 * eta * cos_i * cos_t;
    (product / (perpendicular * perpendicular) + product / (parallel * parallel)).min(1.0)
}

/// The direction refracted at an interface with normal `m` (unit, on the side of `wo`), where `cos_i` = `wo . m` and
/// `cos_t` is [`Interface::cos_t`] for the same `eta`.
#[inline(always)]
pub fn refracted(wo: Vec3, m: Vec3, cos_i: f32, cos_t: f32, eta: f32) -> Vec3 {
    (m * (cos_i / eta - cos_t) - wo / eta).normalize()
}

/// Reflectance per channel of a conductor with index `eta + i k` against a medium of index 1, at `cos_i` in [0, 1].
#[inline(always)]
pub fn conductor(cos_i: f32, eta: Spectrum, k: Spectrum) -> Spectrum {
    let cos_i = cos_i.clamp(0.0, 1.0);
    let ([eta_r, eta_g, eta_b], [k_r, k_g, k_b]) = (eta.0, k.0);
    Spectrum([
        conductor_channel(cos_i, eta_r, k_r),
        conductor_channel(cos_i, eta_g, k_g),
        conductor_channel(cos_i, eta_b, k_b),
    ])
}

/// With a + ib the refracted ray's index times its complex cosine: (a + ib)^2 = (eta + ik)^2 - sin^2.
#[inline(always)]
fn conductor_channel(cos_i: f32, eta: f32, k: f32) -> f32 {
    let sin2 = (1.0 - cos_i) * (1.0 + cos_i);
    let real = eta * eta - k * k - sin2;
    let half_imaginary = eta * k;
    let modulus = (real * real + 4.0 * half_imaginary * half_imaginary).sqrt();
    // a^2 and b^2 are (modulus +- real) / 2: the larger as a sum, the smaller from a b = eta k.
    let larger = 0.5 * (modulus + real.abs());
    let smaller = half_imaginary * half_imaginary / larger.max(f32::MIN_POSITIVE);
    let (a2, b2) = if real >= 0.0 { (larger, smaller) } else { (smaller, larger) };
    let a = a2.sqrt();
    let perpendicular = ratio(a - cos_i, a + cos_i, b2);
    let parallel = perpendicular * ratio(a * cos_i - sin2, a * cos_i + sin2, b2 * cos_i * cos_i);
    (0.5 * (perpendicular + parallel)).min(1.0)
}

/// (minus^2 + rest) / (plus^2 + rest), and 1 for 0 / 0.
#[inline(always)]
fn ratio(minus: f32, plus: f32, rest: f32) -> f32 {
    let denominator = plus * plus + rest;
    let quotient = (minus * minus + rest) / denominator;
    if denominator > 0.0 { quotient } else { 1.0 }
}
