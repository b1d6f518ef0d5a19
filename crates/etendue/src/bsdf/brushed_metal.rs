//! Brushed metal: ideal grooves whose walls are mirrors tilted across them.
//!
//! In the local frame the grooves run along y, so a mirror's normal is tilted by an angle d from z within the plane of x and z,
//! and reflection keeps the component along y: all light that leaves towards `wo` comes from the circle of directions
//! `wi` with `wi.y = -wo.y`. Angles phi on it are counted about y from x, over the side of `wo`: 0 and pi are the horizon, a that
//! of the mirror direction, and a mirror tilted by d reflects from phi = a + 2 d. The distribution of d is
//! proportional to cos^k(d): [`CosinePower`].

use super::{BsdfEval, BsdfSample, Density, Scatter};
use crate::{
    math::{Vec3, vec3},
    sampling::CosinePower,
    spectrum::Spectrum,
};
use std::f64::consts::PI;

/// How the lobe of brushed metal behaves towards the horizon.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GrooveForm {
    /// Reciprocal: f cos(theta) dw is `reflectance C_k cos^k(d) min(1, sin(phi) / sin(a)) dphi`, with `C_k` so that all
    /// tilts sum to 1. Walls in each other's way lose light, the more the lower it comes.
    #[default]
    Reciprocal,
    /// The lobe above the horizon scaled so that all of `reflectance` is scattered at any angle. Not reciprocal.
    Normalised,
}

impl GrooveForm {
    /// Every form.
    pub const ALL: [Self; 2] = [Self::Reciprocal, Self::Normalised];

    /// The name it has in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reciprocal => "reciprocal",
            Self::Normalised => "normalised",
        }
    }
}

/// Brushed metal, the same from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrushedMetal {
    reflectance: Spectrum,
    form: GrooveForm,
    tilts: CosinePower,
}

impl BrushedMetal {
    /// `reflectance` in [0, 1], `exponent` k from 0 to 1e9; towards infinity the metal becomes a mirror.
    #[inline]
    pub fn new(reflectance: Spectrum, exponent: f32, form: GrooveForm) -> Self {
        Self { reflectance, form, tilts: CosinePower::new(exponent) }
    }

    /// The circle that light towards `wo` comes from; `None` along the surface.
    pub(super) fn circle(&self, wo: Vec3) -> Option<Circle> {
        let side = if wo.z < 0.0 { -1.0 } else { 1.0 };
        let [x, y, z] = [f64::from(wo.x), f64::from(wo.y), f64::from(wo.z) * side];
        let radius = (x * x + z * z).sqrt();
        let length = (radius * radius + y * y).sqrt();
        if z <= 0.0 || self.reflectance.is_black() {
            return None;
        }
        let mirror = libm::atan2(z, -x);
        let normaliser = match self.form {
            GrooveForm::Reciprocal => 1.0,
            GrooveForm::Normalised => {
                let [low, high] = visible(mirror).map(|tilt| self.tilts.mass(tilt));
                1.0 / (high - low)
            }
        };
        Some(Circle {
            radius: radius / length,
            along: -y / length,
            side,
            mirror,
            tilts: self.tilts,
            form: self.form,
            normaliser,
            reflectance: self.reflectance,
        })
    }
}

/// Tilts of mirrors that reflect from above the horizon.
#[inline]
fn visible(mirror: f64) -> [f64; 2] {
    [-0.5 * mirror, 0.5 * (PI - mirror)]
}

/// The directions that brushed metal scatters to one direction, and how much comes from each: local frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    /// Length of the directions' component across y, above 0.
    pub radius: f64,
    /// Their component along y.
    pub along: f64,
    /// 1 if the surface is seen from z > 0, else -1.
    pub side: f64,
    /// Angle of the mirror direction, radians in (0, pi).
    pub mirror: f64,
    /// Distribution of the mirrors' tilts.
    pub tilts: CosinePower,
    form: GrooveForm,
    /// What the density of tilts is multiplied by.
    normaliser: f64,
    reflectance: Spectrum,
}

impl Circle {
    /// The unit vector at `phi` radians, in (0, pi).
    #[inline]
    pub fn direction(&self, phi: f64) -> Vec3 {
        let (sin, cos) = libm::sincos(phi);
        vec3((self.radius * cos) as f32, self.along as f32, (self.side * self.radius * sin) as f32)
    }

    /// `f |cos theta|` and the density with which [`Bsdf::sample`](super::Bsdf::sample) draws `phi`, both per radian of `phi`;
    /// 0 outside of (0, pi).
    pub fn eval(&self, phi: f64) -> BsdfEval {
        if !(phi > 0.0 && phi < PI) {
            return BsdfEval::ZERO;
        }
        let sin = libm::sin(0.5 * (phi - self.mirror));
        let density = self.normaliser * self.tilts.density(sin * sin);
        let shadowing = match self.form {
            GrooveForm::Reciprocal => (libm::sin(phi) / libm::sin(self.mirror)).min(1.0),
            GrooveForm::Normalised => 1.0,
        };
        BsdfEval { value: self.reflectance * (density * shadowing) as f32, pdf: density as f32 }
    }
}

impl Scatter for BrushedMetal {
    #[inline]
    fn eval(&self, _wo: Vec3, _wi: Vec3) -> BsdfEval {
        BsdfEval::ZERO
    }

    fn sample(&self, wo: Vec3, _u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 || self.reflectance.is_black() {
            return None;
        }
        let side = 1.0f32.copysign(wo.z);
        let (x, z) = (f64::from(wo.x), f64::from(wo.z * side));
        let (sin, normaliser) = match self.form {
            GrooveForm::Reciprocal => (self.tilts.sample_sine(u), 1.0),
            GrooveForm::Normalised => {
                let [low, high] = visible(libm::atan2(z, -x));
                let [from, to] = [low, high].map(|tilt| self.tilts.mass(tilt));
                let tilt = self.tilts.angle(from + f64::from(u[0]) * (to - from)).clamp(low, high);
                (libm::sin(tilt), 1.0 / (to - from))
            }
        };
        // The mirror direction (-x, z), turned by twice the tilt.
        let (sin2, cos2) = (2.0 * sin * ((1.0 - sin) * (1.0 + sin)).sqrt(), 1.0 - 2.0 * sin * sin);
        let wi = vec3((-x * cos2 - z * sin2) as f32, -wo.y, (z * cos2 - x * sin2) as f32);
        let density = (normaliser * self.tilts.density(sin * sin)) as f32;
        // Far out in the tails densities are 0 in f32.
        if wi.z <= 0.0 || density <= 0.0 {
            return None;
        }
        let weight = match self.form {
            GrooveForm::Reciprocal => self.reflectance * (wi.z / (wo.z * side)).min(1.0),
            GrooveForm::Normalised => self.reflectance,
        };
        // So close to the horizon that nothing is left.
        if weight.is_black() {
            return None;
        }
        let wi = vec3(wi.x, wi.y, wi.z * side);
        Some(BsdfSample { wi, weight, density: Density::Arc(density), transmitted: false, eta: 1.0 })
    }

    #[inline]
    fn is_delta(&self) -> bool {
        true
    }

    #[inline]
    fn transmits(&self) -> bool {
        false
    }

    #[inline]
    fn albedo(&self) -> Spectrum {
        self.reflectance
    }

    #[inline]
    fn is_anisotropic(&self) -> bool {
        true
    }
}
