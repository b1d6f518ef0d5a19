//! What no medium is.

use super::Medium;
use crate::spectrum::Spectrum;

/// Largest coefficient, 1/m: a light year's matter in a hair's breadth, and products with lengths stay finite.
const LARGEST: f32 = 1e15;
/// Largest emission, as that of surfaces.
const BRIGHTEST: f32 = 1e30;

/// A parameter of a medium that is out of range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{parameter}` must be finite, and from 0 to {largest:e}")]
pub struct MediumError {
    parameter: &'static str,
    largest: f32,
}

impl MediumError {
    /// The field that is wrong.
    pub fn parameter(&self) -> &'static str {
        self.parameter
    }
}

impl Medium {
    /// Checks the coefficients. A grid and a phase function are checked where they are made.
    ///
    /// # Errors
    /// [`MediumError`] for a coefficient or an emission that is negative, not finite or too large.
    pub fn validate(&self) -> Result<(), MediumError> {
        let check = |parameter, value: Spectrum, largest| {
            let good = value.0.iter().all(|c| (0.0..=largest).contains(c));
            if good { Ok(()) } else { Err(MediumError { parameter, largest }) }
        };
        check("absorption", self.absorption, LARGEST)?;
        check("scattering", self.scattering, LARGEST)?;
        check("emission", self.emission, BRIGHTEST)
    }

    /// True if a segment without end through this medium, filling all space, would glow without bound: some channel is
    /// emitted and not weakened.
    pub fn glows_without_bound(&self) -> bool {
        let channels = self.emission.0.iter().zip(self.extinction().0);
        self.density.is_none()
            && channels.into_iter().any(|(emission, extinction)| *emission > 0.0 && extinction <= 0.0)
    }
}
