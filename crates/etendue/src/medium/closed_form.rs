//! Flights through what is the same everywhere, in closed form.

use super::{Flight, Medium};
use crate::{
    math::{exp, exp_wide, ln},
    spectrum::Spectrum,
};

/// See [`Medium::sample_flight`].
#[inline]
pub(super) fn sample_flight(medium: &Medium, length: f32, throughput: Spectrum, u: f32) -> Flight {
    let shares = channel_shares(throughput);
    let (channel, u) = choose_channel(shares, u);
    let extinction = medium.extinction();
    let drawn = if extinction.0[channel] > 0.0 { -ln(1.0 - u) / extinction.0[channel] } else { f32::INFINITY };
    let emitted = emitted(medium, length);
    // Where nothing is carried, a weight has no meaning and may have no bound.
    let carried = |weight: Spectrum, over: f32| {
        let mut weight = weight / over;
        for (weight, share) in weight.0.iter_mut().zip(shares.0) {
            *weight = if share > 0.0 { *weight } else { 0.0 };
        }
        weight
    };
    if drawn < length {
        let transmittance = decay(extinction, drawn);
        let density = sum(shares * extinction * transmittance);
        if density > 0.0 {
            let weight = carried(transmittance * medium.scattering, density);
            return Flight { distance: Some(drawn), weight, density, emitted };
        }
    }
    let transmittance = decay(extinction, length);
    let probability = sum(shares * transmittance);
    let weight = if probability > 0.0 { carried(transmittance, probability) } else { Spectrum::BLACK };
    Flight { distance: None, weight, density: 0.0, emitted }
}

/// Light sent along a segment towards its beginning: emission integrated against transmittance. Infinite where nothing
/// weakens it on an infinite segment.
#[inline]
fn emitted(medium: &Medium, length: f32) -> Spectrum {
    if medium.emission.is_black() {
        return Spectrum::BLACK;
    }
    let mut emitted = medium.emission;
    let mean = decay_mean(medium.extinction(), length);
    for (channel, emitted) in emitted.0.iter_mut().enumerate() {
        let k = medium.absorption.0[channel] + medium.scattering.0[channel];
        let reach = if length.is_finite() { length * mean.0[channel] } else { 1.0 / k };
        *emitted = if *emitted > 0.0 { *emitted * reach } else { 0.0 };
    }
    emitted
}

/// `exp(-extinction * distance)`, 1 where nothing is in the way however far.
#[inline]
pub(super) fn decay(extinction: Spectrum, distance: f32) -> Spectrum {
    extinction.map(|k| if k > 0.0 { exp(-k * distance) } else { 1.0 })
}

/// The mean of [`decay`] from 0 to `distance`.
#[inline]
pub(super) fn decay_mean(extinction: Spectrum, distance: f32) -> Spectrum {
    extinction.map(|k| {
        // 0 times infinity is nothing in the way.
        let depth = if k > 0.0 { f64::from(k * distance) } else { 0.0 };
        // (1 - exp(-x)) / x, near 0 by its series.
        let mean = if depth < 1e-4 { 1.0 - 0.5 * depth } else { (1.0 - exp_wide(-depth)) / depth };
        mean as f32
    })
}

#[inline]
pub(super) fn sum(spectrum: Spectrum) -> f32 {
    let [r, g, b] = spectrum.0;
    r + g + b
}

/// Probabilities of channels for a path with this throughput.
#[inline]
pub(super) fn channel_shares(throughput: Spectrum) -> Spectrum {
    let total = sum(throughput);
    if total > 0.0 && total.is_finite() { throughput / total } else { Spectrum::splat(1.0 / 3.0) }
}

/// A channel of a share above 0, and the number that is left, uniform in [0, 1).
#[inline]
pub(super) fn choose_channel(shares: Spectrum, u: f32) -> (usize, f32) {
    const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;
    let [r, g, b] = shares.0;
    // What rounding leaves over goes to the last channel that has a share.
    let last = if b > 0.0 {
        2
    } else if g > 0.0 {
        1
    } else {
        0
    };
    let (channel, before) = if u < r || last == 0 {
        (0, 0.0)
    } else if u < r + g || last == 1 {
        (1, r)
    } else {
        (2, r + g)
    };
    (channel, ((u - before) / shares.0[channel]).clamp(0.0, BELOW_ONE))
}
