//! The GGX (Trowbridge-Reitz) distribution of microfacet normals with Smith's masking, anisotropic, for directions with
//! z >= 0.
//!
//! With s(w) = sqrt(z^2 + (alpha_x x)^2 + (alpha_y y)^2), Smith's Lambda(w) is (s - z) / (2 z), and everything that is
//! needed can be written without dividing by z, so nothing fails at grazing angles:
//! - masking G1 = 2 z / (z + s) (Walter et al. 2007),
//! - height-correlated masking and shadowing G2 = 1 / (1 + Lambda_o + Lambda_i) = 2 z_o z_i / (z_i s_o + z_o s_i)
//!   (Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", 2014).

use super::lanes::lane_numbers;
use crate::math::{PI, Vec3, sin_cos_turns, vec3};

/// Below this alpha a lobe is treated as perfectly specular. A lobe of width alpha needs half vectors better than that,
/// and those of unit vectors in f32 are good to some 1e-7 only.
pub const ALPHA_MIN: f32 = 1e-3;

/// The distribution of normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    alpha_x: f32,
    alpha_y: f32,
}

lane_numbers!(Ggx { alpha_x: f32, alpha_y: f32 });

impl Ggx {
    /// The widest lobe.
    pub(super) const WIDEST: Self = Self { alpha_x: 1.0, alpha_y: 1.0 };

    /// `None` where both widths are below [`ALPHA_MIN`]: perfectly specular. A single width below it is raised to it.
    #[inline(always)]
    pub fn new(alpha_x: f32, alpha_y: f32) -> Option<Self> {
        (alpha_x >= ALPHA_MIN || alpha_y >= ALPHA_MIN)
            .then(|| Self { alpha_x: alpha_x.max(ALPHA_MIN), alpha_y: alpha_y.max(ALPHA_MIN) })
    }

    /// True if the widths along x and y differ.
    #[inline(always)]
    pub fn is_anisotropic(&self) -> bool {
        self.alpha_x != self.alpha_y
    }

    /// Density of normals D(m): facet area per area of surface and steradian; `m` unit.
    #[inline(always)]
    pub fn density(&self, m: Vec3) -> f32 {
        let (x, y) = (m.x / self.alpha_x, m.y / self.alpha_y);
        let e = x * x + y * y + m.z * m.z;
        1.0 / (PI * self.alpha_x * self.alpha_y * (e * e))
    }

    /// s(w), see the module.
    #[inline(always)]
    fn stretched(&self, w: Vec3) -> f32 {
        let (x, y) = (w.x * self.alpha_x, w.y * self.alpha_y);
        (w.z * w.z + x * x + y * y).sqrt()
    }

    /// G1 / z: masking over the cosine.
    #[inline(always)]
    pub fn masking_over_cos(&self, w: Vec3) -> f32 {
        2.0 / (w.z + self.stretched(w))
    }

    /// G1: the visible share of the facets that face `w`.
    #[inline(always)]
    pub fn masking(&self, w: Vec3) -> f32 {
        w.z * self.masking_over_cos(w)
    }

    /// G2 / (z_o z_i), height-correlated, for directions on one side.
    #[inline(always)]
    pub fn masking_shadowing_over_cosines(&self, wo: Vec3, wi: Vec3) -> f32 {
        2.0 / (wi.z * self.stretched(wo) + wo.z * self.stretched(wi)).max(f32::MIN_POSITIVE)
    }

    /// Draws a normal from those visible from `wo` (z > 0), with density G1(wo) D(m) max(0, wo.m) / wo.z per steradian.
    ///
    /// Stretched so that alpha is 1, the visible normals are the half vectors between `wo` and directions uniform on a
    /// spherical cap (Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", 2023). The cap's height is
    /// kept as the distance from the pole, which does not cancel at small angles.
    #[inline(always)]
    pub fn sample_visible(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        self.sample_cap(wo, 1.0, u)
    }

    /// Draws a normal from those visible from `wo` (z > 0), leaving out many from which the reflection would go below the
    /// surface (Eto and Tokuyoshi, "Bounded VNDF Sampling for Smith-GGX Reflections", 2023). For reflection alone:
    /// [`Self::bounded_reflection`] has the density.
    #[inline(always)]
    pub fn sample_bounded(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        self.sample_cap(wo, self.bound(wo), u)
    }

    /// By how much the cap of directions is lower below the horizon, in [0, 1].
    #[inline(always)]
    fn bound(&self, wo: Vec3) -> f32 {
        let alpha = self.alpha_x.min(self.alpha_y).min(1.0);
        let s = 1.0 + (wo.x * wo.x + wo.y * wo.y).sqrt();
        let (alpha2, s2) = (alpha * alpha, s * s);
        (1.0 - alpha2) * s2 / (s2 + alpha2 * (wo.z * wo.z))
    }

    #[inline(always)]
    fn sample_cap(&self, wo: Vec3, bound: f32, u: [f32; 2]) -> Vec3 {
        let w = vec3(wo.x * self.alpha_x, wo.y * self.alpha_y, wo.z).normalize();
        let below_pole = u[1] * (1.0 + bound * w.z);
        let radius = (below_pole * (2.0 - below_pole)).max(0.0).sqrt();
        let (sin, cos) = sin_cos_turns(u[0]);
        let half = vec3(radius * cos + w.x, radius * sin + w.y, (1.0 - below_pole) + w.z);
        let (m, exists) = unit(vec3(half.x * self.alpha_x, half.y * self.alpha_y, half.z));
        let keep = |component: f32, instead: f32| if exists { component } else { instead };
        vec3(keep(m.x, 0.0), keep(m.y, 0.0), keep(m.z, 1.0))
    }

    /// Reflection of a facet distribution with reflectance 1: (f cos_i, density of sampling), for directions with z > 0
    /// and half vector `m`. f cos_i = D G2 / (4 z_o), density = G1(wo) D / (4 z_o).
    #[inline(always)]
    pub fn reflection(&self, wo: Vec3, wi: Vec3, m: Vec3) -> (f32, f32) {
        let quarter = 0.25 * self.density(m);
        (quarter * wi.z * self.masking_shadowing_over_cosines(wo, wi), quarter * self.masking_over_cos(wo))
    }

    /// Weight of a sampled reflection with reflectance 1, in [0, 1]: G2 / G1(wo).
    #[inline(always)]
    pub fn reflection_weight(&self, wo: Vec3, wi: Vec3) -> f32 {
        (wi.z * self.masking_shadowing_over_cosines(wo, wi) / self.masking_over_cos(wo)).min(1.0)
    }

    /// As [`Self::reflection`], with the density of [`Self::sample_bounded`]: D / (2 (k z_o + s)), k being the bound.
    #[inline(always)]
    pub fn bounded_reflection(&self, wo: Vec3, wi: Vec3, m: Vec3) -> (f32, f32) {
        let density = self.density(m);
        let value = 0.25 * density * wi.z * self.masking_shadowing_over_cosines(wo, wi);
        (value, 0.5 * density / (self.bound(wo) * wo.z + self.stretched(wo)))
    }

    /// Weight of a reflection by [`Self::sample_bounded`] with reflectance 1, in [0, 1].
    #[inline(always)]
    pub fn bounded_weight(&self, wo: Vec3, wi: Vec3) -> f32 {
        let over_density = 0.5 * (self.bound(wo) * wo.z + self.stretched(wo));
        (wi.z * self.masking_shadowing_over_cosines(wo, wi) * over_density).min(1.0)
    }
}

/// `v` at unit length, and whether it has a direction; if not, the vector is not to be used.
#[inline(always)]
pub fn unit(v: Vec3) -> (Vec3, bool) {
    let inverse = 1.0 / v.length();
    (v * inverse, (inverse > 0.0) & (inverse < f32::INFINITY))
}

/// Half vector of a reflection between directions with z > 0, and whether there is one: not where both lie in the
/// surface's plane.
#[inline(always)]
pub fn half_vector(wo: Vec3, wi: Vec3) -> (Vec3, bool) {
    unit(wo + wi)
}

/// `wo` reflected by a facet with normal `m`.
#[inline(always)]
pub fn reflected(wo: Vec3, m: Vec3) -> Vec3 {
    (m * (2.0 * wo.dot(m)) - wo).normalize()
}
