//! Shading normals that are not the true ones: no light from below the surface, no black rims.
//!
//! Three things go wrong where a shading normal n, interpolated over a coarse mesh or tilted by a bump or normal map, stands in
//! for the true one g, and each has its remedy. All are factors and geometry about a BSDF, the same for every kind.
//!
//! - *Facets shadow themselves.* Near the terminator a smooth surface is lit where its facet is not. Points of coarse
//!   meshes are lifted onto the smooth surface that the vertex normals stand for (Hanika, "Hacking the Shadow Terminator",
//!   Ray Tracing Gems II, 2021), gather and leave from there, and that surface is the horizon of light; rays from there may
//!   meet the own facet, so that nothing leaks.
//! - *Tilted normals are lit up to a horizon that cuts them off.* Light from the direction wi is multiplied by the shadowing that
//!   bumps of that tilt have as a microsurface (Conty Estevez, Lecocq and Stein, "A Microfacet-Based Shadowing Function to
//!   Solve the Bump Terminator Problem", Ray Tracing Gems, 2019); it falls to 0 towards the horizon. Mirrors do without:
//!   what a bump hides from them is another bump, as bright.
//! - *Tilted normals face away from a viewer who does see the surface*, or reflect the view into it. They are bent as
//!   little as it takes to be seen and, but for Lambertian surfaces, for the mirror direction to be above the horizon (Keller et al., "The Iray Light Transport Simulation
//!   and Rendering System", 2017, A.3).
//!
//! No factor is above 1 and no density changes, so nothing gains energy, and light and BSDF samples still weigh the same
//! integrand. As any shading normal, these are not reciprocal.

use super::wave::Context;
use crate::{bsdf::Bsdf, math::Vec3, surface::SurfacePoint};
use etendue_accel::Hit;

/// Sine of the elevation that the mirror direction of the view is given at least, where the view itself is that high.
const LOWEST_MIRROR: f32 = 0.01;
/// Meshes whose normals differ from their facets' by less than this cosine are smooth as they are.
const SMOOTH: f32 = 0.9999;
/// Slope variance of bumps for the squared tangent of their tilt.
const VARIANCE: f32 = 0.125;

/// From which directions light reaches a vertex.
#[derive(Clone, Copy)]
pub(super) struct Horizon {
    /// Unit normal, on the side of the true one: light on the side of the view comes from above it.
    base: Vec3,
    /// Squared roughness of the bumps; 0 where there are none.
    roughness: f32,
    /// The point on the smooth surface that a coarse mesh stands for.
    pub lifted: Option<Vec3>,
}

impl Horizon {
    /// The horizon of a point seen from `wo`, whose shading normal becomes the one to be used; `relief` is that of bumps.
    /// Points of surfaces that let light through are not lifted.
    #[inline]
    pub fn new(
        context: &Context,
        point: &mut SurfacePoint,
        hit: &Hit,
        wo: Vec3,
        relief: Option<Vec3>,
        bsdf: &Bsdf,
    ) -> Self {
        let true_normal = point.geometric_normal;
        if relief.is_none() && point.shading_normal == true_normal {
            return Self { base: true_normal, roughness: 0.0, lifted: None };
        }
        Self::of_tilted(context, point, hit, wo, relief, bsdf)
    }

    // Kept out of the loop over vertices, most of which are flat or exact spheres.
    #[inline(never)]
    fn of_tilted(
        context: &Context,
        point: &mut SurfacePoint,
        hit: &Hit,
        wo: Vec3,
        relief: Option<Vec3>,
        bsdf: &Bsdf,
    ) -> Self {
        let side = 1f32.copysign(wo.dot(point.geometric_normal));
        let smooth = point.shading_normal;
        let detailed = relief.unwrap_or(smooth);
        let is_coarse = smooth.dot(point.geometric_normal) < SMOOTH;
        let lifted = if is_coarse && !bsdf.transmits() { context.scene.lifted(point, hit, side) } else { None };
        let base = match lifted {
            Some(_) => facing(smooth, point.geometric_normal, wo, side),
            None => point.geometric_normal,
        };
        let normal = match bsdf {
            Bsdf::Diffuse(_) => facing(detailed, base, wo, side),
            _ => bent(detailed * side, base * side, wo) * side,
        };
        point.shading_normal = normal;
        let roughness = if relief.is_some() { squared_roughness(smooth.dot(normal)) } else { 0.0 };
        Self { base, roughness, lifted }
    }

    /// True if light on the side of the view can come from `wi`; `side` is that of the view, 1 or -1.
    #[inline]
    pub fn is_above(&self, wi: Vec3, side: f32) -> bool {
        wi.dot(self.base) * side > 0.0
    }

    /// Unit normal, on the side of the true one: light on the side of the view comes from above it.
    #[inline]
    pub fn base(&self) -> Vec3 {
        self.base
    }

    /// Squared roughness of the bumps; 0 where there are none.
    #[inline]
    pub fn roughness(&self) -> f32 {
        self.roughness
    }

    /// Fraction of light from `wi`, on the side of the view, that bumps leave.
    #[inline]
    pub fn shadowing(&self, wi: Vec3) -> f32 {
        shadowing(wi.dot(self.base), self.roughness)
    }
}

/// Fraction of light that bumps of a squared roughness leave, its direction being under this cosine to the horizon's normal.
#[inline(always)]
pub(super) fn shadowing(cos: f32, roughness: f32) -> f32 {
    let squared = cos * cos;
    let tangent = (1.0 - squared).max(0.0) / squared.max(1e-12);
    let left = 2.0 / (1.0 + (1.0 + roughness * tangent).sqrt());
    if roughness == 0.0 { 1.0 } else { left }
}

/// The squared GGX roughness of bumps whose normal is tilted by this cosine.
fn squared_roughness(cos: f32) -> f32 {
    let squared = cos * cos;
    (VARIANCE * (1.0 - squared).max(0.0) / squared.max(1e-12)).min(1.0)
}

/// `normal`, turned so far that `wo` just sees it from the side from which it sees the true normal.
fn facing(normal: Vec3, true_normal: Vec3, wo: Vec3, side: f32) -> Vec3 {
    let (normal, view) = (normal * side, wo.dot(true_normal * side));
    let (seen, least) = (normal.dot(wo), (0.9 * view).min(LOWEST_MIRROR));
    if seen >= least {
        return normal * side;
    }
    let turned = normal + wo * (least - seen);
    turned.try_normalize().filter(|n| n.dot(true_normal) * side > 0.0).map_or(true_normal, |n| n * side)
}

/// `normal`, bent so far that `wo` is mirrored to above the plane of `base`, as much as it is itself above it.
fn bent(normal: Vec3, base: Vec3, wo: Vec3) -> Vec3 {
    let (seen, view) = (normal.dot(wo), base.dot(wo));
    let mirror = normal * (2.0 * seen) - wo;
    let (height, least) = (mirror.dot(base), (0.9 * view).min(LOWEST_MIRROR));
    if height >= least && seen > 0.0 {
        return normal;
    }
    let raised = (mirror + base * (least - height)).try_normalize();
    raised.and_then(|mirror| (mirror + wo).try_normalize()).filter(|n| n.dot(wo) > 0.0).unwrap_or(base)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec3;

    fn direction(i: u32) -> Vec3 {
        let height = 1.0 - 2.0 * (i as f32 + 0.5) / 1000.0;
        let (sin, cos) = crate::math::sin_cos_turns((i as f32 * 0.618_034).fract());
        let radius = (1.0 - height * height).sqrt();
        vec3(radius * cos, radius * sin, height)
    }

    /// Bent normals see the viewer and mirror it to above the horizon; those that did already stay.
    #[test]
    fn mirrored_views_are_above_the_horizon() {
        let mut bent_ones = 0;
        for (i, j) in (0..500).flat_map(|i| (0..500).step_by(7).map(move |j| (i, j))) {
            let (wo, normal) = (direction(i), direction(j));
            let found = bent(normal, Vec3::Z, wo);
            let mirror = found * (2.0 * found.dot(wo)) - wo;
            assert!((found.length() - 1.0).abs() < 1e-5 && found.dot(wo) > 0.0, "{wo} {normal} {found}");
            assert!(mirror.z > 0.5 * (0.9 * wo.z).min(LOWEST_MIRROR), "{wo} {normal} {mirror}");
            if found != normal {
                bent_ones += 1;
                let before = normal * (2.0 * normal.dot(wo)) - wo;
                assert!(before.z < LOWEST_MIRROR || normal.dot(wo) <= 0.0, "bent without need");
            }
        }
        assert!(bent_ones > 1000);
    }

    #[test]
    fn shadowing_falls_from_1_to_0_at_the_horizon() {
        for tilt in [0.9f32, 0.5, 0.1] {
            let horizon = Horizon { base: Vec3::Z, roughness: squared_roughness(tilt), lifted: None };
            let mut before = 1.0 + 1e-6;
            for i in 0..=1000 {
                let height = 1.0 - i as f32 / 1000.0;
                let shadowing = horizon.shadowing(vec3((1.0 - height * height).sqrt(), 0.0, height));
                assert!(shadowing <= before && shadowing >= 0.0, "{tilt} {height}: {shadowing}");
                before = shadowing;
            }
            assert!((horizon.shadowing(Vec3::Z) - 1.0).abs() < 1e-6 && before < 1e-4);
        }
        assert_eq!(squared_roughness(1.0), 0.0);
    }
}
