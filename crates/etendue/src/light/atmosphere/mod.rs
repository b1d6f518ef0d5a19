//! The light of a clear sky, computed from what air does to sunlight.
//!
//! A round Earth with molecules, aerosol and ozone in layers; in 18 bands of wavelength each direction of the sky gathers
//! sunlight that was scattered once into it (Nishita, Sirai, Tadamura and Nakamae, "Display of the Earth Taking into Account
//! Atmospheric Scattering", 1993) and more often (`multiple`), then bands become a colour. Fitted skies (Preetham,
//! Shirley and Smits 1999; Hosek and Wilkie 2012) are known for the sun above the horizon only, and for one ground; this
//! one goes on through twilight, and its sun and its sky are of one piece.

mod air;
mod bands;
mod multiple;
#[cfg(test)]
mod reference;

use super::RadianceMap;
use crate::{parallel, spectrum::Spectrum};
use air::{Air, Columns, GROUND, SUN_RADIUS, aerosol_phase, along, densities, molecular_phase, noticed, to_top};
pub use bands::EFFICACY;
use bands::{Bands, Colours, LANES, displayable, reflectance};
use etendue_accel::{Isa, Kernel, run};
use multiple::Multiple;
use std::f64::consts::PI;

/// Turbidities of clear to hazy skies; 1 is air without aerosol.
pub const TURBIDITY: std::ops::RangeInclusive<f64> = 1.0..=10.0;

/// Size of the map; half of the rows are above the horizon.
const SIZE: [usize; 2] = [768, 384];
/// Columns and rows of cells that directions are drawn from: without the sun itself the sky is smooth.
pub(crate) const CELLS: [usize; 2] = [SIZE[0] / 3, SIZE[1] / 3];
/// Azimuths from the sun to the opposite where light is gathered; all but phase functions changes slowly between.
const AZIMUTHS: usize = 33;
/// Steps along a line of sight.
const STEPS: usize = 48;
/// Fraction of what aerosol scatters that counts as going straight on: its narrow lobe hardly changes where light is
/// after many turns. Scattering once is computed with all of the lobe and that extinction (Nakajima and Tanaka, "Algorithms for
/// Radiative Intensity Calculations in Moderately Thick Atmospheres Using a Truncation Approximation", 1988). The square of
/// the mean cosine, 0.58, is usual (Joseph, Wiscombe and Weinman, "The Delta-Eddington Approximation", 1976); a little less
/// is nearer to photons in the haze of a low sun.
const AHEAD: f64 = 0.5;

/// A clear sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Atmosphere {
    /// Optical depth of molecules and aerosol over that of molecules alone, straight up at 550 nm, within [`TURBIDITY`]: 2 is
    /// very clear, 3 clear, 6 hazy.
    pub turbidity: f64,
    /// Reflectance of the ground, in [0, 1].
    pub ground: Spectrum,
}

/// What a sun makes of an [`Atmosphere`], as seen from the ground.
#[derive(Clone, Debug)]
pub struct Daylight {
    /// Radiance of sky and ground without the sun itself, W sr^-1 m^-2; the sun stands above the middle column. Below the
    /// horizon is the ground, lit by sun and sky.
    pub map: RadianceMap,
    /// Irradiance by the sun on a plane that faces it, W m^-2; black when it is below the horizon.
    pub sun: Spectrum,
}

/// Light of the sun that is scattered towards the viewer, for sunlight of irradiance 1 and phase functions of 1.
#[derive(Clone, Copy)]
struct Gathered {
    molecular: [f64; 3],
    aerosol: [f64; 3],
    multiple: [f64; 3],
}

impl Gathered {
    fn mix(&self, other: &Self, t: f64) -> Self {
        let mix = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|c| a[c] * (1.0 - t) + b[c] * t);
        Self {
            molecular: mix(self.molecular, other.molecular),
            aerosol: mix(self.aerosol, other.aerosol),
            multiple: mix(self.multiple, other.multiple),
        }
    }

    /// Radiance where the angle between view and sun has this cosine.
    fn radiance(&self, cos: f64) -> [f64; 3] {
        let (molecular, aerosol) = (molecular_phase(cos), aerosol_phase(cos));
        [0, 1, 2].map(|c| self.molecular[c] * molecular + self.aerosol[c] * aerosol + self.multiple[c])
    }
}

/// What the gathering of light needs.
struct Observer {
    air: Air,
    /// The same with all of its extinction, for the sun itself.
    dense: Air,
    columns: Columns,
    multiple: Multiple,
    colours: Colours,
}

impl Atmosphere {
    /// The sky for a sun whose middle is `elevation` radians above the horizon. With the sun below it there is
    /// twilight, down to nothing at all.
    pub fn daylight(&self, elevation: f64) -> Daylight {
        let ground = reflectance(self.ground);
        let (air, columns) = (Air::new(self.turbidity, AHEAD), Columns::new());
        let multiple = Multiple::new(&air, &columns, &ground);
        let observer =
            Observer { air, dense: Air::new(self.turbidity, 0.0), columns, multiple, colours: Colours::new() };
        observer.daylight(elevation, self.ground)
    }
}

impl Observer {
    fn daylight(&self, elevation: f64, ground: Spectrum) -> Daylight {
        let [width, height] = SIZE;
        let (sin_sun, cos_sun) = libm::sincos(elevation);
        let cosines = |row: usize| libm::sincos(PI * (row as f64 + 0.5) / height as f64);
        // Of a column: the cell of its azimuth, the place in it, and the azimuth's cosine.
        let column = |column: usize| {
            let azimuth = PI * ((2 * column + 1) as f64 / width as f64 - 1.0).abs();
            let (from, t) = air::cell(azimuth / PI * (AZIMUTHS - 1) as f64, AZIMUTHS);
            (from, t, libm::cos(azimuth))
        };
        let columns: Vec<(usize, f64, f64)> = (0..width).map(column).collect();
        let cell = 2.0 * PI * PI / (width * height) as f64;
        // The texels of a row, and what they add to the irradiance of the ground.
        let rows = parallel::map(height / 2, |row| {
            let (cos, sin) = cosines(row);
            let sight = LineOfSight { observer: self, sin, sin_sun, cosines: cos * cos_sun };
            let gathered = run(Isa::detect(), sight);
            let texel = |&(from, t, cos_azimuth): &(usize, f64, f64)| {
                let between = (sin * sin_sun + cos * cos_sun * cos_azimuth).clamp(-1.0, 1.0);
                displayable(gathered[from].mix(&gathered[from + 1], t).radiance(between))
            };
            let radiances: Vec<Spectrum> = columns.iter().map(texel).collect();
            let sum = radiances.iter().fold(Spectrum::BLACK, |sum, &radiance| sum + radiance);
            (radiances, sum * (cell * cos * sin) as f32)
        });
        let mut texels = Vec::with_capacity(width * height);
        let mut irradiance = Spectrum::BLACK;
        for (radiances, part) in rows {
            texels.extend(radiances.iter().map(|radiance| radiance.0));
            irradiance += part;
        }
        let sun = self.sun(elevation);
        irradiance += sun * sin_sun.max(0.0) as f32;
        let below = ground * irradiance * (1.0 / PI) as f32;
        texels.resize(width * height, below.0);
        // The size is right by construction.
        let map = RadianceMap::new(width as u32, height as u32, texels).unwrap_or_else(|_| unreachable!("{SIZE:?}"));
        Daylight { map, sun }
    }

    /// Irradiance by the sun on a plane that faces it; of a sun that sets, as bright as the middle of what is visible.
    fn sun(&self, elevation: f64) -> Spectrum {
        if elevation <= -SUN_RADIUS {
            return Spectrum::BLACK;
        }
        let lowest = (elevation - SUN_RADIUS).max(0.0);
        let middle = 0.5 * (lowest + elevation + SUN_RADIUS);
        displayable(self.colours.sum(&self.columns.at(GROUND).unobstructed(&self.dense, libm::sin(middle))))
    }
}

/// A line of sight whose elevation has a sine, beside that of the sun and the product of the cosines of both.
struct LineOfSight<'a> {
    observer: &'a Observer,
    sin: f64,
    sin_sun: f64,
    cosines: f64,
}

impl Kernel for LineOfSight<'_> {
    type Output = Vec<Gathered>;

    /// What it gathers, for each azimuth.
    #[inline(always)]
    fn run(self) -> Vec<Gathered> {
        let Self { observer: Observer { air, columns, multiple, colours, .. }, sin, sin_sun, cosines } = self;
        let length = to_top(GROUND, sin);
        let mut sums = vec![[[0.0; LANES]; 3]; AZIMUTHS];
        let mut passed: Bands = [1.0; LANES];
        let cosine: [f64; AZIMUTHS] =
            std::array::from_fn(|k| libm::cos(PI * k as f64 / (AZIMUTHS - 1) as f64) * cosines + sin * sin_sun);
        for i in 0..STEPS {
            let (start, end) = (i as f64 / STEPS as f64, (i + 1) as f64 / STEPS as f64);
            let (from, to) = (length * start * start, length * end * end);
            let middle = 0.5 * (from + to);
            let (there, _) = along(GROUND, sin, middle);
            let density = densities(there - GROUND);
            let scattered = multiple::step(air, density, to - from, &mut passed);
            let all = air.scattering(density);
            let [molecules, particles, _] = noticed(density);
            let (mut molecular, mut aerosol) = ([0.0; LANES], [0.0; LANES]);
            for b in 0..LANES {
                let all = all[b].max(f32::MIN_POSITIVE);
                molecular[b] = air.molecular[b] * molecules / all;
                aerosol[b] = air.aerosol[b] * particles / all;
            }
            let (columns, multiple) = (columns.at(there), multiple.at(there - GROUND));
            let mut mu_sun = [0.0; AZIMUTHS];
            for k in 0..AZIMUTHS {
                mu_sun[k] = ((GROUND * sin_sun + middle * cosine[k]) / there).clamp(-1.0, 1.0);
            }
            let light = columns.sunlight(air, &mu_sun);
            for ((sum, light), mu_sun) in sums.iter_mut().zip(&light).zip(mu_sun) {
                let again = multiple.towards(mu_sun);
                for b in 0..LANES {
                    let single = scattered[b] * light[b];
                    sum[0][b] += single * molecular[b];
                    sum[1][b] += single * aerosol[b];
                    sum[2][b] += scattered[b] * again[b];
                }
            }
        }
        let colour = |sum: &[Bands; 3]| {
            let [molecular, aerosol, multiple] = [0, 1, 2].map(|i| colours.sum(&sum[i]));
            Gathered { molecular, aerosol, multiple }
        };
        sums.iter().map(colour).collect()
    }
}
