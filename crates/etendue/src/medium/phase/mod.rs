//! Phase functions: where light goes that a medium scatters.
//!
//! `wo` and `wi` are unit vectors away from the scattering point, `wo` to where the light goes, `wi` to where it comes from;
//! the scattering angle is that between `-wi` and `wo`. A phase function's value is its density: it integrates to 1.

mod half_cosine;
mod henyey_greenstein;
mod isotropic;
mod lambert_sphere;
mod rayleigh;

use crate::math::{Frame, Vec3, sin_cos_turns, vec3};
use half_cosine::HalfCosine;
use henyey_greenstein::HenyeyGreenstein;
use isotropic::Isotropic;
use lambert_sphere::LambertSphere;
use rayleigh::Rayleigh;

/// One shape of scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PhaseKind {
    /// Alike in all directions.
    Isotropic,
    /// Tiny white balls with a matte surface: most light goes back; mean cosine -4/9
    /// (Lambert's law over the lit and seen part of a sphere, as for the phases of a planet: Seeliger, 1887).
    LambertSphere,
    /// Proportional to the cosine of half the angle from the direction back: a rough likeness of [`Self::LambertSphere`]; mean
    /// cosine -1/5.
    HalfCosine,
    /// Forward or backward lobe (Henyey and Greenstein, "Diffuse radiation in the galaxy", 1941).
    HenyeyGreenstein {
        /// Mean cosine of the scattering angle, in (-1, 1): above 0 most light goes on, below 0 most goes back.
        g: f32,
    },
    /// Particles much smaller than the wavelength, unpolarised light (Rayleigh, 1871).
    Rayleigh,
}

/// A shape and its share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseComponent {
    /// The shape.
    pub kind: PhaseKind,
    /// Its probability, at least 0; all components' sum to 1.
    pub weight: f32,
}

/// A mixture of shapes.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseFunction {
    components: Vec<PhaseComponent>,
}

/// A direction drawn from a phase function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseSample {
    /// Unit vector, away from the scattering point, to where the light comes from.
    pub wi: Vec3,
    /// Density per steradian, and value.
    pub pdf: f32,
}

/// What is no phase function.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PhaseError {
    /// Too few or too many components.
    #[error("a phase function is a mixture of 1 to {max} shapes, not of {0}", max = PhaseFunction::MAX_COMPONENTS)]
    Count(usize),
    /// A weight that is negative or not finite.
    #[error("the weight {0} of a phase function is negative or not finite")]
    Weight(f32),
    /// All weights are 0.
    #[error("all weights of a phase function are 0")]
    NoWeight,
    /// A mean cosine that no lobe has.
    #[error("the mean cosine {0} of a Henyey-Greenstein phase function is not between -1 and 1")]
    MeanCosine(f32),
}

/// A scattering angle by its distance from both ends, each precise where it is small; `ahead + behind = 2`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Deflection {
    /// 1 - cosine of the scattering angle: 0 straight on.
    ahead: f32,
    /// 1 + cosine of the scattering angle: 0 back to where the light came from.
    behind: f32,
}

impl Deflection {
    #[inline]
    fn between(wo: Vec3, wi: Vec3) -> Self {
        Self { ahead: (0.5 * (wo + wi).length_squared()).min(2.0), behind: (0.5 * (wo - wi).length_squared()).min(2.0) }
    }

    /// By 1 - cosine, in [0, 2].
    #[inline]
    fn from_ahead(ahead: f32) -> Self {
        Self { ahead, behind: 2.0 - ahead }
    }

    /// By 1 + cosine, in [0, 2].
    #[inline]
    fn from_behind(behind: f32) -> Self {
        Self { ahead: 2.0 - behind, behind }
    }

    #[inline]
    fn cosine(self) -> f32 {
        0.5 * (self.behind - self.ahead)
    }
}

/// What every shape does. All are symmetric about the direction of the light.
trait Lobe {
    /// Density per steradian.
    fn density(&self, deflection: Deflection) -> f32;
    /// Draws a scattering angle with this density, `u` in [0, 1).
    fn sample(&self, u: f32) -> Deflection;
    /// Mean cosine of the scattering angle.
    fn mean_cosine(&self) -> f32;
}

macro_rules! dispatch {
    ($kind:expr, $lobe:ident => $call:expr) => {
        match $kind {
            PhaseKind::Isotropic => {
                let $lobe = Isotropic;
                $call
            }
            PhaseKind::LambertSphere => {
                let $lobe = LambertSphere;
                $call
            }
            PhaseKind::HalfCosine => {
                let $lobe = HalfCosine;
                $call
            }
            PhaseKind::HenyeyGreenstein { g } => {
                let $lobe = HenyeyGreenstein { g };
                $call
            }
            PhaseKind::Rayleigh => {
                let $lobe = Rayleigh;
                $call
            }
        }
    };
}

impl PhaseKind {
    /// All shapes, with parameters of no importance.
    pub const ALL: [Self; 5] =
        [Self::Isotropic, Self::LambertSphere, Self::HalfCosine, Self::HenyeyGreenstein { g: 0.0 }, Self::Rayleigh];

    /// The name it has in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Isotropic => "isotropic",
            Self::LambertSphere => "lambert-sphere",
            Self::HalfCosine => "half-cosine",
            Self::HenyeyGreenstein { .. } => "henyey-greenstein",
            Self::Rayleigh => "rayleigh",
        }
    }

    /// Mean cosine of the scattering angle, in (-1, 1).
    pub fn mean_cosine(self) -> f32 {
        dispatch!(self, lobe => lobe.mean_cosine())
    }

    #[inline]
    fn density(self, deflection: Deflection) -> f32 {
        dispatch!(self, lobe => lobe.density(deflection))
    }

    #[inline]
    fn sample(self, u: f32) -> Deflection {
        dispatch!(self, lobe => lobe.sample(u))
    }
}

impl Default for PhaseFunction {
    fn default() -> Self {
        PhaseKind::Isotropic.into()
    }
}

impl From<PhaseKind> for PhaseFunction {
    /// One shape alone. A Henyey-Greenstein lobe's `g` is brought into the range of [`PhaseFunction::mixture`].
    fn from(kind: PhaseKind) -> Self {
        const LARGEST: f32 = 1.0 - f32::EPSILON / 2.0;
        let kind = match kind {
            PhaseKind::HenyeyGreenstein { g } if g.is_nan() => PhaseKind::Isotropic,
            PhaseKind::HenyeyGreenstein { g } => PhaseKind::HenyeyGreenstein { g: g.clamp(-LARGEST, LARGEST) },
            kind => kind,
        };
        Self { components: vec![PhaseComponent { kind, weight: 1.0 }] }
    }
}

impl PhaseFunction {
    /// Most shapes of a mixture.
    pub const MAX_COMPONENTS: usize = 16;

    /// A mixture; weights are divided by their sum.
    ///
    /// # Errors
    /// [`PhaseError`] for none or too many components, for a weight that is negative or not finite, if all weights are 0, and for a
    /// mean cosine outside of (-1, 1).
    pub fn mixture(components: &[PhaseComponent]) -> Result<Self, PhaseError> {
        if components.is_empty() || components.len() > Self::MAX_COMPONENTS {
            return Err(PhaseError::Count(components.len()));
        }
        for component in components {
            if !(component.weight >= 0.0 && component.weight.is_finite()) {
                return Err(PhaseError::Weight(component.weight));
            }
            if let PhaseKind::HenyeyGreenstein { g } = component.kind
                && (g.is_nan() || g.abs() >= 1.0)
            {
                return Err(PhaseError::MeanCosine(g));
            }
        }
        // In f64, so that no sum overflows.
        let total: f64 = components.iter().map(|c| f64::from(c.weight)).sum();
        if total <= 0.0 {
            return Err(PhaseError::NoWeight);
        }
        let share = |c: &PhaseComponent| PhaseComponent { weight: (f64::from(c.weight) / total) as f32, ..*c };
        Ok(Self { components: components.iter().map(share).collect() })
    }

    /// The shapes with their shares.
    pub fn components(&self) -> &[PhaseComponent] {
        &self.components
    }

    /// Mean cosine of the scattering angle, in (-1, 1).
    pub fn mean_cosine(&self) -> f32 {
        self.components.iter().map(|c| c.weight * c.kind.mean_cosine()).sum()
    }

    /// Value and density per steradian; the same with `wo` and `wi` exchanged.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.density(Deflection::between(wo, wi))
    }

    /// Draws a direction: `u_lobe` in [0, 1) chooses the shape, `u` in [0, 1)^2 the direction.
    #[inline]
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> PhaseSample {
        let deflection = self.choose(u_lobe).sample(u[0]);
        let sine = (deflection.ahead * deflection.behind).max(0.0).sqrt();
        let (sin, cos) = sin_cos_turns(u[1]);
        // `wi` straight on is `-wo`.
        let wi = Frame::from_normal(-wo).to_world(vec3(sine * cos, sine * sin, deflection.cosine()));
        PhaseSample { wi, pdf: self.density(deflection) }
    }

    #[inline]
    fn density(&self, deflection: Deflection) -> f32 {
        match self.components[..] {
            [PhaseComponent { kind, .. }] => kind.density(deflection),
            _ => self.components.iter().map(|c| c.weight * c.kind.density(deflection)).sum(),
        }
    }

    #[inline]
    fn choose(&self, u: f32) -> PhaseKind {
        let mut left = u;
        for component in &self.components {
            if left < component.weight {
                return component.kind;
            }
            left -= component.weight;
        }
        // What rounding leaves over goes to the last that may be chosen.
        self.components.iter().rev().find(|c| c.weight > 0.0).map_or(PhaseKind::Isotropic, |c| c.kind)
    }
}
