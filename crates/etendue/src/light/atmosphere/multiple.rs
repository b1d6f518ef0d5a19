//! Light that was scattered more than once.

use super::{
    air::{Air, Columns, GROUND, TOP, along, cell, densities, to_ground, to_top},
    bands::{BANDS, Bands},
};
use crate::{math::exp_wide, parallel};
use etendue_accel::{Isa, Kernel, run};
use std::f64::consts::PI;

const HEIGHTS: usize = 12;
const SUNS: usize = 32;
/// Directions in height, and in azimuth over half a turn.
const POLAR: usize = 10;
const AZIMUTHS: usize = 4;
const STEPS: usize = 20;

/// Radiance that arrives on average from all around by scattering before the last, for sunlight of irradiance 1, over height
/// and the sun's direction. All orders but the first are taken to scatter evenly, which makes them a geometric series
/// (Hillaire, "A Scalable and Production Ready Sky and Atmosphere Rendering Technique", 2020).
pub struct Multiple(Vec<Bands>);

/// One direction out of a height: its steps, and what it meets at the end.
struct Path {
    /// Distance, scattering times the transmittance up to the step, integrated over it.
    steps: Vec<(f64, Bands)>,
    /// Distance and transmittance to the ground.
    ground: Option<(f64, Bands)>,
}

impl Path {
    #[inline(always)]
    fn new(air: &Air, r: f64, mu: f64) -> Self {
        let hit = to_ground(r, mu);
        let length = hit.unwrap_or_else(|| to_top(r, mu));
        let mut passed = [1.0; BANDS];
        let mut steps = Vec::with_capacity(STEPS);
        for i in 0..STEPS {
            let (from, to) = (length * square(i as f64 / STEPS as f64), length * square((i + 1) as f64 / STEPS as f64));
            let middle = 0.5 * (from + to);
            let (there, _) = along(r, mu, middle);
            steps.push((middle, step(air, densities(there - GROUND), to - from, &mut passed)));
        }
        Self { steps, ground: hit.map(|distance| (distance, passed)) }
    }
}

#[inline(always)]
fn square(x: f64) -> f64 {
    x * x
}

/// Scattering out of a step of `length`, m, at these densities; `passed`, the transmittance up to the step, goes on to its
/// end.
#[inline(always)]
pub fn step(air: &Air, densities: [f64; 3], length: f64, passed: &mut Bands) -> Bands {
    let [molecules, aerosol, ozone] = densities;
    let depth = air.depth([molecules * length, aerosol * length, ozone * length]);
    let mut scattered = air.scattering(densities);
    for i in 0..BANDS {
        let rest = exp_wide(-depth[i]);
        // The mean of e^-x over the step.
        let mean = if depth[i] > 1e-4 { (1.0 - rest) / depth[i] } else { 1.0 - 0.5 * depth[i] };
        scattered[i] = scattered[i] * length * mean * passed[i];
        passed[i] *= rest;
    }
    scattered
}

fn height(index: usize) -> f64 {
    (TOP - GROUND) * square(index as f64 / (HEIGHTS - 1) as f64)
}

/// The sun's cosine at a table row: close rows about the horizon.
fn sun_cosine(index: usize) -> f64 {
    let x = 2.0 * index as f64 / (SUNS - 1) as f64 - 1.0;
    x * x.abs()
}

impl Multiple {
    /// `ground` is the reflectance of the ground.
    pub fn new(air: &Air, columns: &Columns, ground: &Bands) -> Self {
        let at_height = |i: usize| run(Isa::detect(), MultipleAt { air, columns, ground, height: height(i) });
        Self(parallel::map(HEIGHTS, at_height).concat())
    }

    /// At height `height` above the ground, m, where the sun's cosine against the vertical is `mu_sun`.
    #[inline(always)]
    pub fn at(&self, height: f64, mu_sun: f64) -> Bands {
        let (i, fx) = cell((height / (TOP - GROUND)).max(0.0).sqrt() * (HEIGHTS - 1) as f64, HEIGHTS);
        let sun = 0.5 + 0.5 * mu_sun.abs().sqrt().copysign(mu_sun);
        let (j, fy) = cell(sun * (SUNS - 1) as f64, SUNS);
        let place = i * SUNS + j;
        let (here, next) = (&self.0[place..place + 2], &self.0[place + SUNS..place + SUNS + 2]);
        let weights = [(1.0 - fx) * (1.0 - fy), (1.0 - fx) * fy, fx * (1.0 - fy), fx * fy];
        let mut bands = [0.0; BANDS];
        for b in 0..BANDS {
            bands[b] =
                here[0][b] * weights[0] + here[1][b] * weights[1] + next[0][b] * weights[2] + next[1][b] * weights[3];
        }
        bands
    }
}

/// The entries of [`Multiple`] at one height.
struct MultipleAt<'a> {
    air: &'a Air,
    columns: &'a Columns,
    ground: &'a Bands,
    height: f64,
}

impl Kernel for MultipleAt<'_> {
    type Output = Vec<Bands>;

    #[inline(always)]
    fn run(self) -> Vec<Bands> {
        let Self { air, columns, ground, height } = self;
        let r = GROUND + height;
        let mut paths = Vec::with_capacity(POLAR);
        for k in 0..POLAR {
            let mu = 2.0 * (k as f64 + 0.5) / POLAR as f64 - 1.0;
            paths.push((mu, Path::new(air, r, mu)));
        }
        let again = scattered_again(&paths, ground);
        let mut entries = Vec::with_capacity(SUNS);
        for j in 0..SUNS {
            let mut entry = second_order((air, columns), &paths, r, sun_cosine(j), ground);
            for b in 0..BANDS {
                entry[b] /= 1.0 - again[b];
            }
            entries.push(entry);
        }
        entries
    }
}

/// What returns on average of light that goes out evenly in all directions.
fn scattered_again(paths: &[(f64, Path)], ground: &Bands) -> Bands {
    let mut sum = [0.0; BANDS];
    for (_, path) in paths {
        for (_, scattered) in &path.steps {
            (0..BANDS).for_each(|b| sum[b] += scattered[b]);
        }
        if let Some((_, passed)) = &path.ground {
            (0..BANDS).for_each(|b| sum[b] += passed[b] * ground[b]);
        }
    }
    sum.map(|s| s / POLAR as f64)
}

/// Mean over all directions of the radiance that sunlight of irradiance 1 makes when it is scattered once.
#[inline(always)]
fn second_order((air, columns): (&Air, &Columns), paths: &[(f64, Path)], r: f64, mu_sun: f64, ground: &Bands) -> Bands {
    let mut sum = [0.0; BANDS];
    let sin_sun = (1.0 - mu_sun * mu_sun).max(0.0).sqrt();
    for (mu, path) in paths {
        let sin = (1.0 - mu * mu).max(0.0).sqrt();
        for k in 0..AZIMUTHS {
            let cos_between = mu * mu_sun + sin * sin_sun * libm::cos(PI * (k as f64 + 0.5) / AZIMUTHS as f64);
            let sun = (mu_sun, cos_between);
            for (distance, scattered) in &path.steps {
                let (there, mu_there) = sun_at((r, *mu), sun, *distance);
                let light = columns.sunlight(air, there, mu_there);
                for b in 0..BANDS {
                    sum[b] += scattered[b] * light[b] / (4.0 * PI);
                }
            }
            if let Some((distance, passed)) = &path.ground {
                let (_, mu_there) = sun_at((r, *mu), sun, *distance);
                let light = columns.sunlight(air, GROUND, mu_there);
                let facing = mu_there.max(0.0) / PI;
                for b in 0..BANDS {
                    sum[b] += passed[b] * ground[b] * light[b] * facing;
                }
            }
        }
    }
    sum.map(|s| s / (POLAR * AZIMUTHS) as f64)
}

/// Radius, and the sun's cosine against the vertical there, at a distance along a direction of which both are known at its
/// start; the sun's cosine against the direction stands beside.
#[inline(always)]
fn sun_at((r, mu): (f64, f64), (mu_sun, cos_between): (f64, f64), distance: f64) -> (f64, f64) {
    let (there, _) = along(r, mu, distance);
    (there, ((r * mu_sun + distance * cos_between) / there).clamp(-1.0, 1.0))
}
