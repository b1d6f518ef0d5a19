//! Participating media: what fills space and absorbs, scatters and emits light on its way.
//!
//! Coefficients are per channel, so a free flight that is drawn for one channel must serve all three: a distance is drawn
//! for one channel picked by the path's throughput, and weighted by the mean of all channels' densities (the one-sample
//! balance heuristic over channels; Veach 1997, 9.2; Wilkie et al., "Hero Wavelength Spectral Sampling", 2014).

mod equiangular;
mod phase;

pub use equiangular::Equiangular;
pub use phase::{PhaseComponent, PhaseFunction, PhaseKind, PhaseSample};

use crate::{
    math::{Vec3, exp, ln},
    sampling::Stream,
    spectrum::Spectrum,
};

/// What fills space.
#[derive(Clone, Debug, PartialEq)]
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
    /// Extinction coefficient, 1/m.
    #[inline]
    pub fn extinction(&self) -> Spectrum {
        self.absorption + self.scattering
    }

    /// Draws a free flight along `segment` for a path with `throughput`. `u` in [0, 1) places it; `stream` gives the numbers of
    /// a loop without bound where density varies.
    #[inline]
    pub fn sample_flight(&self, segment: &Segment, throughput: Spectrum, u: f32, stream: &mut Stream) -> Flight {
        let _ = stream;
        let shares = channel_shares(throughput);
        let (channel, u) = choose_channel(shares, u);
        let extinction = self.extinction();
        let drawn = if extinction.0[channel] > 0.0 { -ln(1.0 - u) / extinction.0[channel] } else { f32::INFINITY };
        let emitted = self.emitted(segment.length.min(f32::MAX));
        if drawn < segment.length {
            let transmittance = decay(extinction, drawn);
            let density = sum(shares * extinction * transmittance);
            let weight = transmittance * self.scattering / density;
            return Flight { distance: Some(drawn), weight, density, emitted };
        }
        let transmittance = decay(extinction, segment.length);
        let probability = sum(shares * transmittance);
        Flight { distance: None, weight: transmittance / probability, density: 0.0, emitted }
    }

    /// Density per metre with which [`Self::sample_flight`] ends `distance` along `segment`. Where density varies it is not known,
    /// and this is a stand-in of about the same size, good for weights of multiple importance sampling alone.
    #[inline]
    pub fn flight_density(&self, segment: &Segment, throughput: Spectrum, distance: f32) -> f32 {
        let _ = segment;
        let extinction = self.extinction();
        sum(channel_shares(throughput) * extinction * decay(extinction, distance))
    }

    /// Fraction of light that passes a segment, an unbiased estimate; exact where density is the same everywhere.
    #[inline]
    pub fn transmittance(&self, segment: &Segment, stream: &mut Stream) -> Spectrum {
        let _ = stream;
        decay(self.extinction(), segment.length)
    }

    /// Scattering coefficient at a point relative to the scene's centre, 1/m.
    #[inline]
    pub fn scattering_at(&self, point: Vec3) -> Spectrum {
        let _ = point;
        self.scattering
    }

    /// True if light passes as through nothing.
    pub fn is_vacuum(&self) -> bool {
        self.extinction().is_black() && self.emission.is_black()
    }

    /// Light sent along a segment towards its beginning: emission integrated against transmittance.
    fn emitted(&self, length: f32) -> Spectrum {
        let extinction = self.extinction();
        let mut emitted = self.emission;
        for (emitted, extinction) in emitted.0.iter_mut().zip(extinction.0) {
            let depth = extinction * length;
            // (1 - exp(-x)) / x, near 0 by its series.
            let mean = if depth < 1e-3 { 1.0 - 0.5 * depth } else { (1.0 - exp(-depth)) / depth };
            *emitted = if *emitted > 0.0 { *emitted * length * mean } else { 0.0 };
        }
        emitted
    }
}

/// `exp(-extinction * distance)`, 1 where nothing is in the way however far.
#[inline]
fn decay(extinction: Spectrum, distance: f32) -> Spectrum {
    extinction.map(|k| if k > 0.0 { exp(-k * distance) } else { 1.0 })
}

#[inline]
fn sum(spectrum: Spectrum) -> f32 {
    let [r, g, b] = spectrum.0;
    r + g + b
}

/// Probabilities of channels for a path with this throughput.
#[inline]
fn channel_shares(throughput: Spectrum) -> Spectrum {
    let total = sum(throughput);
    if total > 0.0 && total.is_finite() { throughput / total } else { Spectrum::splat(1.0 / 3.0) }
}

/// A channel and the number that is left, uniform in [0, 1).
#[inline]
fn choose_channel(shares: Spectrum, u: f32) -> (usize, f32) {
    let [r, g, b] = shares.0;
    const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;
    if u < r {
        (0, (u / r).min(BELOW_ONE))
    } else if u < r + g || b <= 0.0 {
        (1, ((u - r) / g).clamp(0.0, BELOW_ONE))
    } else {
        (2, ((u - r - g) / b).clamp(0.0, BELOW_ONE))
    }
}
