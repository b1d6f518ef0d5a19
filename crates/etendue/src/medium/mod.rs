//! Participating media: what fills space and absorbs, scatters and emits light on its way.
//!
//! Coefficients are per channel, so a free flight that is drawn for one channel must serve all three: a distance is drawn
//! for one channel picked by the path's throughput, and weighted by the mean of all channels' densities (the one-sample
//! balance heuristic over channels; Veach 1997, 9.2; Wilkie et al., "Hero Wavelength Spectral Sampling", 2014).

mod check;
mod closed_form;
mod equiangular;
mod grid;
mod phase;
pub mod presets;

pub use check::MediumError;
pub use equiangular::Equiangular;
pub use grid::{Density, DensityGrid, GridError, Voxels};
pub use phase::{PhaseComponent, PhaseError, PhaseFunction, PhaseKind, PhaseSample};

use crate::{
    math::{DVec3, Vec3},
    sampling::Stream,
    spectrum::Spectrum,
};
use closed_form::{channel_shares, decay, sum};
use grid::Track;

/// What fills space. The default is nothing: it lets all light pass.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Medium {
    /// As in the file.
    pub name: String,
    /// Absorption coefficient, 1/m, per channel, finite and at least 0.
    pub absorption: Spectrum,
    /// Scattering coefficient, 1/m, per channel, finite and at least 0.
    pub scattering: Spectrum,
    /// Emitted radiance per metre, W sr^-1 m^-3, finite and at least 0.
    pub emission: Spectrum,
    /// Where scattered light goes.
    pub phase: PhaseFunction,
    /// Multiplies the coefficients and the emission from place to place; absent: 1 everywhere.
    pub density: Option<Density>,
}

/// A piece of a ray inside one medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Relative to the scene's centre, metres.
    pub origin: Vec3,
    /// Unit length.
    pub direction: Vec3,
    /// Metres; may be infinite.
    pub length: f32,
}

/// Where a free flight ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// Metres to where the light is scattered; `None` if the end of the segment is reached.
    pub distance: Option<f32>,
    /// What the throughput is multiplied by: transmittance (times the scattering coefficient) over probability (density).
    pub weight: Spectrum,
    /// What [`Medium::flight_density`] gives for `distance`; 0 where there is none.
    pub density: f32,
    /// Light that the medium sends back along the segment, an unbiased estimate before the weight.
    pub emitted: Spectrum,
}

impl Medium {
    /// Extinction coefficient, 1/m; of density 1 where it varies.
    #[inline]
    pub fn extinction(&self) -> Spectrum {
        self.absorption + self.scattering
    }

    /// The same with points given relative to `center`, as a scene has them; at first they are relative to the world's origin.
    pub fn relative_to(&self, center: DVec3) -> Self {
        Self { density: self.density.as_ref().map(|density| density.relative_to(center)), ..self.clone() }
    }

    /// Draws a free flight along `segment` for a path with `throughput`. `u` in [0, 1) places it; `stream` gives the numbers of
    /// a loop without bound where density varies.
    #[inline]
    pub fn sample_flight(&self, segment: &Segment, throughput: Spectrum, u: f32, stream: &mut Stream) -> Flight {
        match &self.density {
            None => closed_form::sample_flight(self, segment.length, throughput, u),
            Some(density) => Track::new(self, density, segment).sample_flight(throughput, u, stream),
        }
    }

    /// Density per metre with which [`Self::sample_flight`] ends `distance` along `segment`. Where density varies it is not known,
    /// and this is a stand-in of about the same size, good for weights of multiple importance sampling alone.
    #[inline]
    pub fn flight_density(&self, segment: &Segment, throughput: Spectrum, distance: f32) -> f32 {
        match &self.density {
            None => {
                let extinction = self.extinction();
                sum(channel_shares(throughput) * extinction * decay(extinction, distance))
            }
            Some(density) => Track::new(self, density, segment).density_of_flight(throughput, f64::from(distance)),
        }
    }

    /// Fraction of light that passes a segment, an unbiased estimate; exact where density is the same everywhere.
    #[inline]
    pub fn transmittance(&self, segment: &Segment, stream: &mut Stream) -> Spectrum {
        match &self.density {
            None => decay(self.extinction(), segment.length),
            Some(density) => Track::new(self, density, segment).transmittance(stream),
        }
    }

    /// Scattering coefficient at a point relative to the scene's centre, 1/m.
    #[inline]
    pub fn scattering_at(&self, point: Vec3) -> Spectrum {
        match &self.density {
            None => self.scattering,
            Some(density) => self.scattering * density.at(point),
        }
    }

    /// True if no light passes an endless way through it.
    pub fn hides_infinity(&self) -> bool {
        self.density.is_none() && self.extinction().min_component() > 0.0
    }

    /// True if light passes as through nothing.
    pub fn is_vacuum(&self) -> bool {
        let nothing = self.extinction().is_black() && self.emission.is_black();
        nothing || self.density.as_ref().is_some_and(|density| density.largest() <= 0.0)
    }
}
