//! What the air is made of, and how much of it is in the way.

use super::bands::{Bands, LANES, at_middles, narrow, ozone};
use crate::{
    math::{exp_short, exp_wide},
    parallel,
};
use etendue_accel::{Isa, Kernel, run};
use std::f64::consts::PI;

/// Mean radius of the Earth, m.
pub const GROUND: f64 = 6_371_000.0;
/// Where the air ends, as distance from the Earth's middle, m.
pub const TOP: f64 = GROUND + 100_000.0;
/// Heights over which molecules and aerosol thin out by e, m.
const SCALE_HEIGHTS: [f64; 2] = [8000.0, 1200.0];
/// The ozone layer: height of its middle and half of its thickness, m; a triangle (Bruneton, "A Qualitative and Quantitative
/// Evaluation of 8 Clear Sky Models", 2017).
const OZONE_LAYER: [f64; 2] = [25_000.0, 15_000.0];
/// Ozone above a square metre, molecules: 300 Dobson units of 2.687e20.
const OZONE_COLUMN: f64 = 300.0 * 2.687e20;
/// Molecules of air above a square metre at sea level, 1013.25 hPa.
const AIR_COLUMN: f64 = 2.1486e29;
/// Aerosol: fraction of light that is scattered and not absorbed, and how its optical depth falls with wavelength
/// (Angstrom's exponent, of ordinary continental air).
const AEROSOL_ALBEDO: f64 = 0.92;
const ANGSTROM: f64 = 1.3;
/// Mean cosine of scattering by aerosol.
pub const ASYMMETRY: f64 = 0.76;
/// Half of the angle that the sun is seen under, radians.
pub const SUN_RADIUS: f64 = 0.2666 * PI / 180.0;

/// Scattering cross section of a molecule of air, m^2, of dry air with 360 ppm CO2, `wavelength` in nm: Bodhaine, Wood,
/// Dutton and Slusser, "On Rayleigh Optical Depth Calculations", 1999, equation 29.
fn molecule(wavelength: f64) -> f64 {
    let squared = (wavelength * 1e-3) * (wavelength * 1e-3);
    let over = 1.045_599_6 - 341.290_61 / squared - 0.902_308_50 * squared;
    let below = 1.0 + 0.002_705_988_9 / squared - 85.968_563 * squared;
    1e-32 * over / below
}

/// Optical depth of the molecules from sea level straight up.
fn molecular_depth(wavelength: f64) -> f64 {
    molecule(wavelength) * AIR_COLUMN
}

/// Amounts of molecules, aerosol and ozone: densities relative to where they are greatest, or these along a path, m.
pub type Amounts = [f64; 3];

/// Densities at a height above sea level, m.
#[inline(always)]
pub fn densities(height: f64) -> Amounts {
    let (molecules, aerosol) = (exp_wide(-height / SCALE_HEIGHTS[0]), exp_wide(-height / SCALE_HEIGHTS[1]));
    [molecules, aerosol, (1.0 - (height - OZONE_LAYER[0]).abs() / OZONE_LAYER[1]).max(0.0)]
}

/// Optical coefficients where each part is densest, 1/m.
pub struct Air {
    /// Of molecules.
    pub molecular: Bands,
    /// Scattering by aerosol, all of it.
    pub aerosol: Bands,
    /// Scattering by aerosol that counts as such where light is scattered more than once.
    broad: Bands,
    /// Extinction by molecules, aerosol, ozone.
    extinction: [Bands; 3],
}

impl Air {
    /// `turbidity` is the optical depth of molecules and aerosol straight up over that of molecules, at 550 nm. The fraction
    /// `ahead` of what aerosol scatters counts as going straight on, so that it is no extinction.
    pub fn new(turbidity: f64, ahead: f64) -> Self {
        let molecular = at_middles(|w| molecular_depth(w) / SCALE_HEIGHTS[0]);
        let aerosol_depth = (turbidity - 1.0) * molecular_depth(550.0);
        let extinction = at_middles(|w| aerosol_depth * libm::pow(w / 550.0, -ANGSTROM) / SCALE_HEIGHTS[1]);
        let ozone = ozone().map(|section| section * OZONE_COLUMN / OZONE_LAYER[1]);
        let aerosol = extinction.map(|e| e * AEROSOL_ALBEDO);
        let broad = aerosol.map(|a| a * (1.0 - ahead));
        let stopped = extinction.map(|e| e * (1.0 - AEROSOL_ALBEDO * ahead));
        let [molecular, aerosol, broad, stopped, ozone] = [molecular, aerosol, broad, stopped, ozone].map(narrow);
        Self { molecular, aerosol, broad, extinction: [molecular, stopped, ozone] }
    }

    /// Optical depth of amounts along a path.
    #[inline(always)]
    pub fn depth(&self, amounts: Amounts) -> Bands {
        let [molecules, aerosol, ozone] = &self.extinction;
        let amounts = noticed(amounts);
        let mut depth = [0.0; LANES];
        for i in 0..LANES {
            depth[i] = molecules[i] * amounts[0] + aerosol[i] * amounts[1] + ozone[i] * amounts[2];
        }
        depth
    }

    /// Fraction of light that passes amounts along a path.
    #[inline(always)]
    pub fn transmittance(&self, amounts: Amounts) -> Bands {
        let mut bands = self.depth(amounts);
        for band in &mut bands {
            *band = exp_short(-*band);
        }
        bands
    }

    /// Scattering by all parts at these densities, without what goes straight on, 1/m.
    #[inline(always)]
    pub fn scattering(&self, densities: Amounts) -> Bands {
        let densities = noticed(densities);
        let mut scattering = [0.0; LANES];
        for (i, sum) in scattering.iter_mut().enumerate() {
            *sum = self.molecular[i] * densities[0] + self.broad[i] * densities[1];
        }
        scattering
    }
}

/// Amounts with fewer digits; so little that its products would lose theirs is nothing.
#[inline(always)]
pub fn noticed(amounts: Amounts) -> [f32; 3] {
    let mut noticed = [0.0; 3];
    for i in 0..3 {
        noticed[i] = if amounts[i] > 1e-20 { amounts[i] as f32 } else { 0.0 };
    }
    noticed
}

/// Density per steradian of scattering by molecules, of the cosine of the scattering angle; with the depolarisation 0.0279
/// of air (Chandrasekhar, "Radiative Transfer", 1960).
pub fn molecular_phase(cos: f64) -> f64 {
    const GAMMA: f64 = 0.0279 / (2.0 - 0.0279);
    3.0 / (16.0 * PI * (1.0 + 2.0 * GAMMA)) * (1.0 + 3.0 * GAMMA + (1.0 - GAMMA) * cos * cos)
}

/// The same of scattering by aerosol (Henyey and Greenstein, 1941).
pub fn aerosol_phase(cos: f64) -> f64 {
    let base = 1.0 + ASYMMETRY * ASYMMETRY - 2.0 * ASYMMETRY * cos;
    (1.0 - ASYMMETRY * ASYMMETRY) / (4.0 * PI * base * base.sqrt())
}

/// Distance from radius `r` to the top of the air in a direction with cosine `mu` against the vertical.
#[inline(always)]
pub fn to_top(r: f64, mu: f64) -> f64 {
    (r * r * (mu * mu - 1.0) + TOP * TOP).max(0.0).sqrt() - r * mu
}

/// Distance to the ground, if the direction meets it.
pub fn to_ground(r: f64, mu: f64) -> Option<f64> {
    let discriminant = r * r * (mu * mu - 1.0) + GROUND * GROUND;
    (mu < 0.0 && discriminant >= 0.0).then(|| (-r * mu - discriminant.sqrt()).max(0.0))
}

/// Radius and cosine against the vertical at distance `s` along a direction.
#[inline(always)]
pub fn along(r: f64, mu: f64, s: f64) -> (f64, f64) {
    let there = (r * r + s * s + 2.0 * r * mu * s).max(GROUND * GROUND).sqrt();
    (there, ((r * mu + s) / there).clamp(-1.0, 1.0))
}

/// Amounts along paths that leave the air, tabulated over radius and direction as Bruneton and Neyret, "Precomputed
/// Atmospheric Scattering", 2008, do, with the direction by the distance to the top.
pub struct Columns(Vec<Amounts>);

const RADII: usize = 64;
const DIRECTIONS: usize = 128;

/// Distance to the ground's horizon from radius `r`, and from the top.
#[inline(always)]
fn horizon_distance(r: f64) -> f64 {
    ((r - GROUND) * (r + GROUND)).max(0.0).sqrt()
}

impl Columns {
    pub fn new() -> Self {
        let far = horizon_distance(TOP);
        let row = |i: usize| run(Isa::detect(), ColumnsAt { rho: far * i as f64 / (RADII - 1) as f64, far });
        Self(parallel::map(RADII, row).concat())
    }

    /// The tables at radius `r`.
    #[inline(always)]
    pub fn at(&self, r: f64) -> ColumnsFrom<'_> {
        let (rho, far) = (horizon_distance(r), horizon_distance(TOP));
        let nearest = TOP - r;
        let (row, part) = cell(rho / far * (RADII - 1) as f64, RADII);
        ColumnsFrom {
            rows: &self.0[row * DIRECTIONS..(row + 2) * DIRECTIONS],
            part,
            r,
            horizon: horizon_cosine(r),
            half_sun: SUN_RADIUS * GROUND / r,
            nearest,
            scale: (DIRECTIONS - 1) as f64 / (rho + far - nearest).max(1.0),
        }
    }
}

/// [`Columns`] as seen from one radius: what does not depend on the direction.
pub struct ColumnsFrom<'a> {
    /// Of the two nearest radii in the table.
    rows: &'a [Amounts],
    /// How far between them.
    part: f64,
    r: f64,
    /// Cosine of the horizon.
    horizon: f64,
    /// Change of the cosine from the sun's middle to its rim.
    half_sun: f64,
    /// Distance straight up to the top, and the table's cells for each metre that the way there is longer.
    nearest: f64,
    scale: f64,
}

impl ColumnsFrom<'_> {
    /// Amounts up to the top in directions with these cosines; of directions that meet the ground those of the horizon.
    #[inline(always)]
    fn amounts<const N: usize>(&self, mu: &[f64; N]) -> [Amounts; N] {
        // All roots before all table cells, so that there are several at once.
        let mut places = [0.0; N];
        for k in 0..N {
            let d = to_top(self.r, mu[k].max(self.horizon));
            places[k] = ((d - self.nearest) * self.scale).clamp(0.0, (DIRECTIONS - 1) as f64);
        }
        let (lower, upper) = self.rows.split_at(DIRECTIONS);
        let mut amounts = [[0.0; 3]; N];
        for k in 0..N {
            let i = (places[k] as usize).min(DIRECTIONS - 2);
            let (fx, fy) = (places[k] - i as f64, self.part);
            let ([a, b], [c, d]) = ([lower[i], lower[i + 1]], [upper[i], upper[i + 1]]);
            for part in 0..3 {
                let (row, next) = (a[part] * (1.0 - fx) + b[part] * fx, c[part] * (1.0 - fx) + d[part] * fx);
                amounts[k][part] = row * (1.0 - fy) + next * fy;
            }
        }
        amounts
    }

    /// Fractions of sunlight that arrive where the sun's cosine against the vertical is one of `mu`; the sun sets over its
    /// width.
    #[inline(always)]
    pub fn sunlight<const N: usize>(&self, air: &Air, mu: &[f64; N]) -> [Bands; N] {
        let mut visible = [0.0; N];
        for k in 0..N {
            let t = ((mu[k] - self.horizon) / self.half_sun * 0.5 + 0.5).clamp(0.0, 1.0);
            visible[k] = (t * t * (3.0 - 2.0 * t)) as f32;
        }
        let amounts = self.amounts(mu);
        let mut light = [[0.0; LANES]; N];
        for k in 0..N {
            if visible[k] > 0.0 {
                light[k] = air.transmittance(amounts[k]);
                for light in &mut light[k] {
                    *light *= visible[k];
                }
            }
        }
        light
    }

    /// Fraction of light from outside that arrives if the ground is not in the way; below the horizon as at it.
    pub fn unobstructed(&self, air: &Air, mu: f64) -> Bands {
        air.transmittance(self.amounts(&[mu])[0])
    }
}

/// Cosine against the vertical of the horizon seen from radius `r`, at most 0.
#[inline(always)]
pub fn horizon_cosine(r: f64) -> f64 {
    -horizon_distance(r) / r
}

/// Table cell and position in it.
#[inline(always)]
pub fn cell(x: f64, count: usize) -> (usize, f64) {
    let x = x.clamp(0.0, (count - 1) as f64);
    let i = (x as usize).min(count - 2);
    (i, x - i as f64)
}

/// The amounts of [`Columns`] at one radius, by its distance to the ground's horizon and that of the top.
struct ColumnsAt {
    rho: f64,
    far: f64,
}

impl Kernel for ColumnsAt {
    type Output = Vec<Amounts>;

    #[inline(always)]
    fn run(self) -> Vec<Amounts> {
        let Self { rho, far } = self;
        let r = (rho * rho + GROUND * GROUND).sqrt();
        let (nearest, farthest) = (TOP - r, rho + far);
        let (mut distances, mut cosines) = ([0.0; DIRECTIONS], [0.0; DIRECTIONS]);
        for j in 0..DIRECTIONS {
            let d = nearest + (farthest - nearest) * j as f64 / (DIRECTIONS - 1) as f64;
            let mu: f64 = if d > 0.0 { ((far - rho) * (far + rho) - d * d) / (2.0 * r * d) } else { 1.0 };
            (distances[j], cosines[j]) = (d, mu.clamp(-1.0, 1.0));
        }
        columns(r, &cosines, &distances)
    }
}

/// Amounts over distances in many directions, by Simpson's rule in steps that are short where the path is lowest.
#[inline(always)]
fn columns(r: f64, cosines: &[f64; DIRECTIONS], distances: &[f64; DIRECTIONS]) -> Vec<Amounts> {
    const STEPS: usize = 64;
    let mut sums = [[0.0; DIRECTIONS]; 3];
    for i in 0..=STEPS {
        let t = i as f64 / STEPS as f64;
        let weight = if i == 0 || i == STEPS { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
        for j in 0..DIRECTIONS {
            let d = distances[j];
            // s = d t^2, ds = 2 d t dt.
            let (there, _) = along(r, cosines[j], d * t * t);
            let density = densities(there - GROUND);
            let scale = weight / (3.0 * STEPS as f64) * 2.0 * d * t;
            sums[0][j] += density[0] * scale;
            sums[1][j] += density[1] * scale;
            sums[2][j] += density[2] * scale;
        }
    }
    (0..DIRECTIONS).map(|j| [sums[0][j], sums[1][j], sums[2][j]]).collect()
}

#[cfg(test)]
mod tests {
    use super::{super::bands::BANDS, *};

    #[test]
    fn the_sun_sets_over_its_width() {
        let (air, columns) = (Air::new(1.0, 0.0), Columns::new());
        let from = columns.at(GROUND + 500.0);
        let heights = [-1.01, -0.5, 0.0, 0.5, 1.01];
        let mu = heights.map(|height| from.horizon + height * from.half_sun);
        for ((light, mu), share) in from.sunlight(&air, &mu).iter().zip(mu).zip([0.0, 0.156_25, 0.5, 0.843_75, 1.0]) {
            let all = from.unobstructed(&air, mu);
            assert!(
                all[BANDS - 1] > 0.01
                    && light.iter().zip(&all).all(|(part, all)| (part - share * all).abs() <= 1e-6 * all)
            );
        }
    }
}
