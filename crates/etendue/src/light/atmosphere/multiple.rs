//! Light that was scattered more than once.

use super::{
    air::{Air, Columns, ColumnsFrom, GROUND, TOP, along, cell, densities, to_ground, to_top},
    bands::{Bands, LANES},
};
use crate::{math::exp_short, parallel};
use etendue_accel::{Isa, Kernel, run};
use std::f64::consts::PI;

const HEIGHTS: usize = 12;
const SUNS: usize = 32;
/// Directions in height, and in azimuth over half a turn.
const POLAR: usize = 10;
const AZIMUTHS: usize = 4;
const STEPS: usize = 20;
/// Density per steradian of scattering alike in all directions.
const EVEN: f32 = (0.25 / PI) as f32;

/// Radiance that arrives on average from all around by scattering before the last, for sunlight of irradiance 1, over height
/// and the sun's direction. All orders but the first are taken to scatter evenly, which makes them a geometric series
/// (Hillaire, "A Scalable and Production Ready Sky and Atmosphere Rendering Technique", 2020).
pub struct Multiple(Vec<Bands>);

/// One direction out of a height: its steps, and what it meets at the end.
struct Path<'a> {
    steps: Vec<Step<'a>>,
    /// The ground, with the transmittance up to it.
    ground: Option<Step<'a>>,
}

/// A place on a path.
struct Step<'a> {
    distance: f64,
    /// Radius.
    there: f64,
    columns: ColumnsFrom<'a>,
    /// Scattering times the transmittance up to the step, integrated over it.
    scattered: Bands,
}

impl<'a> Path<'a> {
    #[inline(always)]
    fn new(air: &Air, columns: &'a Columns, r: f64, mu: f64) -> Self {
        let hit = to_ground(r, mu);
        let length = hit.unwrap_or_else(|| to_top(r, mu));
        let mut passed = [1.0; LANES];
        let mut steps = Vec::with_capacity(STEPS);
        for i in 0..STEPS {
            let (from, to) = (length * square(i as f64 / STEPS as f64), length * square((i + 1) as f64 / STEPS as f64));
            let middle = 0.5 * (from + to);
            let (there, _) = along(r, mu, middle);
            let scattered = step(air, densities(there - GROUND), to - from, &mut passed);
            steps.push(Step { distance: middle, there, columns: columns.at(there), scattered });
        }
        let ground = hit.map(|distance| {
            let (there, _) = along(r, mu, distance);
            Step { distance, there, columns: columns.at(GROUND), scattered: passed }
        });
        Self { steps, ground }
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
    let length = length as f32;
    for i in 0..LANES {
        let rest = exp_short(-depth[i]);
        // The mean of e^-x over the step.
        let near = 1.0 - depth[i] * (0.5 - depth[i] * (1.0 / 6.0));
        let mean = if depth[i] > 0.03 { (1.0 - rest) / depth[i] } else { near };
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

    /// The table at height `height` above the ground, m.
    #[inline(always)]
    pub fn at(&self, height: f64) -> MultipleFrom<'_> {
        let (row, part) = cell((height / (TOP - GROUND)).max(0.0).sqrt() * (HEIGHTS - 1) as f64, HEIGHTS);
        MultipleFrom { rows: &self.0[row * SUNS..(row + 2) * SUNS], part }
    }
}

/// [`Multiple`] at one height.
pub struct MultipleFrom<'a> {
    /// Of the two nearest heights in the table.
    rows: &'a [Bands],
    /// How far between them.
    part: f64,
}

impl MultipleFrom<'_> {
    /// Where the sun's cosine against the vertical is `mu_sun`.
    #[inline(always)]
    pub fn towards(&self, mu_sun: f64) -> Bands {
        let sun = 0.5 + 0.5 * mu_sun.abs().sqrt().copysign(mu_sun);
        let (j, fy) = cell(sun * (SUNS - 1) as f64, SUNS);
        let (lower, upper) = self.rows.split_at(SUNS);
        let (here, next, fx) = (&lower[j..j + 2], &upper[j..j + 2], self.part);
        let (fx, fy) = (fx as f32, fy as f32);
        let weights = [(1.0 - fx) * (1.0 - fy), (1.0 - fx) * fy, fx * (1.0 - fy), fx * fy];
        let mut bands = [0.0; LANES];
        for b in 0..LANES {
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
            paths.push((mu, Path::new(air, columns, r, mu)));
        }
        let again = scattered_again(&paths, ground);
        let mut entries = second_order(air, &paths, r, ground);
        for (entry, b) in entries.iter_mut().flat_map(|entry| entry.iter_mut().zip(&again)) {
            *entry /= 1.0 - b;
        }
        entries.to_vec()
    }
}

/// What returns on average of light that goes out evenly in all directions.
fn scattered_again(paths: &[(f64, Path)], ground: &Bands) -> Bands {
    let mut sum = [0.0; LANES];
    for (_, path) in paths {
        for Step { scattered, .. } in &path.steps {
            (0..LANES).for_each(|b| sum[b] += scattered[b]);
        }
        if let Some(Step { scattered: passed, .. }) = &path.ground {
            (0..LANES).for_each(|b| sum[b] += passed[b] * ground[b]);
        }
    }
    sum.map(|s| s / POLAR as f32)
}

/// Mean over all directions of the radiance that sunlight of irradiance 1 makes when it is scattered once, for each of the
/// sun's cosines.
#[inline(always)]
fn second_order(air: &Air, paths: &[(f64, Path)], r: f64, ground: &Bands) -> [Bands; SUNS] {
    let mut sums = [[0.0; LANES]; SUNS];
    let suns: [f64; SUNS] = std::array::from_fn(sun_cosine);
    for (mu, path) in paths {
        let sin = (1.0 - mu * mu).max(0.0).sqrt();
        for k in 0..AZIMUTHS {
            let turn = libm::cos(PI * (k as f64 + 0.5) / AZIMUTHS as f64);
            let mut between = [0.0; SUNS];
            for j in 0..SUNS {
                between[j] = mu * suns[j] + sin * (1.0 - suns[j] * suns[j]).max(0.0).sqrt() * turn;
            }
            // The suns' cosines against the vertical at a place.
            let suns_at = |step: &Step| {
                let mut there = [0.0; SUNS];
                for j in 0..SUNS {
                    there[j] = ((r * suns[j] + step.distance * between[j]) / step.there).clamp(-1.0, 1.0);
                }
                there
            };
            for step in &path.steps {
                let light = step.columns.sunlight(air, &suns_at(step));
                for (sum, light) in sums.iter_mut().zip(&light) {
                    for b in 0..LANES {
                        sum[b] += step.scattered[b] * light[b] * EVEN;
                    }
                }
            }
            if let Some(step) = &path.ground {
                let there = suns_at(step);
                let light = step.columns.sunlight(air, &there);
                for ((sum, light), mu) in sums.iter_mut().zip(&light).zip(there) {
                    let facing = (mu.max(0.0) / PI) as f32;
                    for b in 0..LANES {
                        sum[b] += step.scattered[b] * ground[b] * light[b] * facing;
                    }
                }
            }
        }
    }
    sums.map(|sum| sum.map(|s| s / (POLAR * AZIMUTHS) as f32))
}
