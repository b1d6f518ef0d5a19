//! Radiance from infinity out of an image, sampled as it is.

use super::{Emitter, LightContext, LightSample, is_unit};
use crate::{
    bsdf::Density,
    math::{DMat3, Vec3, atan2, floor, sin_cos_turns, vec3},
    parallel,
    sampling::Distribution2D,
    spectrum::Spectrum,
};
use std::{f32::consts::PI, ops::Range, sync::Arc};

/// Most texels of a [`RadianceMap`]: 1.5 GiB.
pub const MAX_MAP_TEXELS: u64 = 1 << 27;
/// Largest texel of a [`RadianceMap`].
const BRIGHTEST: f32 = 1e30;
/// What stands in for infinity in a map: the largest number of half precision, where such infinities come from.
const INFINITE: f32 = 65504.0;

/// Cells of the sampling grid, columns and rows: a texel each where the map is within these bounds.
const COLUMNS: Range<usize> = 64..2048;
/// See [`COLUMNS`].
const ROWS: Range<usize> = 32..1024;
/// Share of the samples that cells which shine at all get alike, however dark: where the sun is hidden, the rest of the sky
/// counts, and positions inside a cell need bits too.
const EVEN_SHARE: f64 = 1.0 / 16.0;

/// Why a [`RadianceMap`] cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RadianceMapError {
    /// No texels, or more than [`MAX_MAP_TEXELS`].
    #[error("an environment of {0} x {1} pixels; it must have from 1 to {max}", max = MAX_MAP_TEXELS)]
    Size(u32, u32),
    /// The number of texels is not width times height.
    #[error("an environment of {expected} pixels came with {found}")]
    Count {
        /// Width times height.
        expected: u64,
        /// How many came.
        found: u64,
    },
}

/// An equirectangular image of linear radiance. It covers the sphere whatever its width and height: columns are longitudes,
/// rows latitudes, the first row at the top.
#[derive(Clone, Debug, PartialEq)]
pub struct RadianceMap {
    width: u32,
    height: u32,
    texels: Box<[[f32; 3]]>,
    repaired: u64,
}

impl RadianceMap {
    /// From texels row by row, W sr^-1 m^-2. Texels with components that are negative or not a number count as 0 in these,
    /// infinite ones as 65504, and none is above 1e30; see [`RadianceMap::repaired`].
    ///
    /// # Errors
    /// [`RadianceMapError`] if there are none, too many, or not `width` x `height`.
    pub fn new(width: u32, height: u32, mut texels: Vec<[f32; 3]>) -> Result<Self, RadianceMapError> {
        let expected = u64::from(width) * u64::from(height);
        if expected == 0 || expected > MAX_MAP_TEXELS {
            return Err(RadianceMapError::Size(width, height));
        }
        if expected != texels.len() as u64 {
            return Err(RadianceMapError::Count { expected, found: texels.len() as u64 });
        }
        let mut repaired = 0;
        // Most maps are fine, which is seen sooner than each is mended.
        let fine = texels.as_flattened().iter().fold(true, |fine, c| fine & (*c >= 0.0) & (*c <= BRIGHTEST));
        for texel in texels.iter_mut().filter(|_| !fine) {
            let fine = texel.map(|c| match c {
                f32::INFINITY => INFINITE,
                c if c > 0.0 => c.min(BRIGHTEST),
                _ => 0.0,
            });
            repaired += u64::from(fine != *texel);
            *texel = fine;
        }
        Ok(Self { width, height, texels: texels.into(), repaired })
    }

    /// A sky that depends on the height alone: from `horizon` to `top` and to `bottom`, linear in the sine of the elevation.
    pub fn gradient(top: Spectrum, horizon: Spectrum, bottom: Spectrum) -> Result<Self, RadianceMapError> {
        const HEIGHT: u32 = 512;
        let row = |row: u32| {
            let height = libm::cos((f64::from(row) + 0.5) / f64::from(HEIGHT) * std::f64::consts::PI) as f32;
            let far = if height > 0.0 { top } else { bottom };
            (horizon * (1.0 - height.abs()) + far * height.abs()).0
        };
        Self::new(1, HEIGHT, (0..HEIGHT).map(row).collect())
    }

    /// Width and height, texels.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// How many texels had to be changed because they were negative, not finite or too large.
    pub fn repaired(&self) -> u64 {
        self.repaired
    }

    #[inline]
    fn texel(&self, x: usize, y: usize) -> Spectrum {
        Spectrum(self.texels[y * self.width as usize + x])
    }

    /// Radiance at (u, v) in [0, 1]^2, v from the top, bilinear: `u` goes round, `v` ends at the poles.
    #[inline]
    pub fn lookup(&self, u: f32, v: f32) -> Spectrum {
        let (width, height) = (self.width as usize, self.height as usize);
        let x = u * self.width as f32 - 0.5;
        let y = (v * self.height as f32 - 0.5).clamp(0.0, (height - 1) as f32);
        let (left, top) = (floor(x), floor(y));
        let (fx, fy) = (x - left, y - top);
        let wrap = |column: i64| column.rem_euclid(width as i64) as usize;
        let (x0, x1) = (wrap(left as i64), wrap((left as i64).saturating_add(1)));
        let (y0, y1) = (top as usize, (top as usize + 1).min(height - 1));
        let row = |y: usize| self.texel(x0, y) * (1.0 - fx) + self.texel(x1, y) * fx;
        row(y0) * (1.0 - fy) + row(y1) * fy
    }
}

/// Radiance from infinity by a [`RadianceMap`], sampled in two dimensions in proportion to radiance and solid angle.
///
/// In the map's own space y is up, the centre column looks along +z, and +x is a quarter of the width left of it (the
/// convention of OpenEXR's latitude-longitude maps); so, seen from inside, the picture is not mirrored.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageEnvironment {
    map: Arc<RadianceMap>,
    strength: Spectrum,
    /// The map's axes in the world, unit length.
    axes: [Vec3; 3],
    /// Which cell; cells of a row have the same solid angle.
    cells: Distribution2D,
    columns: usize,
    /// Cosines of the polar angles between rows, from the top pole to the bottom.
    cosines: Vec<f64>,
    /// Mean over the sphere, strength included.
    mean: Spectrum,
}

impl ImageEnvironment {
    /// Turns `map` by the rotation `orientation` (map to world) and multiplies it by `strength`, not negative.
    pub fn new(map: Arc<RadianceMap>, orientation: DMat3, strength: Spectrum) -> Self {
        let cells = [cell_count(map.width, COLUMNS), cell_count(map.height, ROWS)];
        Self::with_cells(map, orientation, strength, cells)
    }

    /// The same with a sampling grid of so many columns and rows, at least one of each: few where the map is smooth.
    pub(crate) fn with_cells(
        map: Arc<RadianceMap>,
        orientation: DMat3,
        strength: Spectrum,
        [columns, rows]: [usize; 2],
    ) -> Self {
        let cosines: Vec<f64> =
            (0..=rows).map(|row| libm::cos(row as f64 / rows as f64 * std::f64::consts::PI)).collect();
        let (weights, mean) = cell_weights(&map, strength, columns, &cosines);
        let weights = chosen(weights, columns, &cosines);
        // Weights are finite and few enough by the bounds on texels and cells; else the sky is left to BSDF samples.
        let cells = Distribution2D::new(&weights, columns).unwrap_or_default();
        let axes = [orientation.x_axis, orientation.y_axis, orientation.z_axis].map(|a| a.as_vec3());
        Self { map, strength, axes, cells, columns, cosines, mean }
    }

    /// Longitude and latitude of a unit vector in [0, 1]^2.
    #[inline]
    fn coordinates(&self, wi: Vec3) -> [f32; 2] {
        let [x, y, z] = self.axes.map(|axis| axis.dot(wi));
        let polar = atan2((x * x + z * z).sqrt(), y);
        [0.5 - atan2(x, z) * (0.5 / PI), polar * (1.0 / PI)]
    }

    /// Radiance from the direction of the unit vector `wi`.
    #[inline]
    pub fn radiance_from(&self, wi: Vec3) -> Spectrum {
        let [u, v] = self.coordinates(wi);
        self.map.lookup(u, v) * self.strength
    }

    /// Density per solid angle at longitude and latitude.
    #[inline]
    fn density(&self, [u, v]: [f32; 2]) -> f32 {
        let rows = self.cosines.len() - 1;
        let row = ((v * rows as f32) as usize).min(rows - 1);
        let column = ((u * self.columns as f32) as usize).min(self.columns - 1);
        let solid_angle = (self.cosines[row] - self.cosines[row + 1]) as f32 * (2.0 * PI) / self.columns as f32;
        self.cells.probability(row, column) / solid_angle
    }
}

impl Emitter for ImageEnvironment {
    #[inline]
    fn radiance(&self) -> Spectrum {
        self.mean
    }

    fn etendue(&self, scene_radius: f64) -> f64 {
        super::environment::etendue(scene_radius)
    }

    /// The direction is uniform in the solid angle of a cell.
    #[inline]
    fn sample(&self, _ctx: &LightContext, u: [f32; 2]) -> Option<LightSample> {
        let cell = self.cells.choose(u)?;
        let [across, down] = cell.remapped;
        let (top, bottom) = (self.cosines[cell.row], self.cosines[cell.row + 1]);
        let height = top + (bottom - top) * f64::from(down);
        let (sin, cos) = sin_cos_turns(0.5 - (cell.column as f32 + across) / self.columns as f32);
        let radius = ((1.0 - height) * (1.0 + height)).max(0.0).sqrt() as f32;
        let local = vec3(radius * sin, height as f32, radius * cos);
        let [x, y, z] = self.axes;
        let wi = (x * local.x + y * local.y + z * local.z).normalize();
        // By the direction, rounded as it is, so that this is what a ray along it finds.
        let at = self.coordinates(wi);
        let density = self.density(at);
        let radiance = self.map.lookup(at[0], at[1]) * self.strength;
        (density > 0.0 && is_unit(wi)).then_some(LightSample {
            wi,
            at: [0.0; 2],
            target: None,
            radiance,
            density: Density::SolidAngle(density),
        })
    }

    #[inline]
    fn pdf(&self, _ctx: &LightContext, wi: Vec3, _distance: f32) -> f32 {
        self.density(self.coordinates(wi))
    }
}

/// How many cells along a side of so many texels: one a texel within the bounds; what does not change is one cell.
fn cell_count(texels: u32, bounds: Range<usize>) -> usize {
    match texels as usize {
        1 => 1,
        texels if texels < bounds.start => texels * bounds.start.div_ceil(texels),
        texels => texels.min(bounds.end),
    }
}

/// Integral of the bilinear filter's hat from -1 up to `t`.
fn hat_integral(t: f64) -> f64 {
    let t = t.clamp(-1.0, 1.0);
    if t < 0.0 { 0.5 * (1.0 + t) * (1.0 + t) } else { 1.0 - 0.5 * (1.0 - t) * (1.0 - t) }
}

/// The texels that the bilinear lookup mixes over cell `cell` of `cells`, with their shares of the cell's mean; their
/// numbers may be beyond the ends.
fn footprint(cell: usize, cells: usize, texels: u32) -> impl Iterator<Item = (i64, f64)> {
    let scale = f64::from(texels) / cells as f64;
    let (from, to) = (cell as f64 * scale, (cell + 1) as f64 * scale);
    let (first, last) = ((from - 0.5).floor() as i64, (to - 0.5).floor() as i64 + 1);
    (first..=last).map(move |texel| {
        let center = texel as f64 + 0.5;
        (texel, (hat_integral(to - center) - hat_integral(from - center)) / scale)
    })
}

/// For each cell the mean of its looked-up radiance, summed over the channels with the strength, times its solid angle; and
/// the mean radiance of the sphere. A cell is 0 only where every lookup in it is.
fn cell_weights(map: &RadianceMap, strength: Spectrum, columns: usize, cosines: &[f64]) -> (Vec<f64>, Spectrum) {
    let (width, rows) = (map.width as usize, cosines.len() - 1);
    let strength = strength.0.map(f64::from);
    let across: Vec<Vec<(usize, f64)>> = (0..columns)
        .map(|column| {
            let wrap = |(texel, share): (i64, f64)| (texel.rem_euclid(width as i64) as usize, share);
            footprint(column, columns, map.width).map(wrap).collect()
        })
        .collect();
    let row = |row: usize| {
        let solid_angle = (cosines[row] - cosines[row + 1]) / columns as f64 * 2.0 * std::f64::consts::PI;
        let (mut line, mut mean) = (vec![0.0f64; width], [0.0f64; 3]);
        for (texel, share) in footprint(row, rows, map.height) {
            let y = texel.clamp(0, i64::from(map.height) - 1) as usize;
            let mut sums = [0.0f64; 3];
            for (sum, texel) in line.iter_mut().zip(&map.texels[y * width..(y + 1) * width]) {
                let [r, g, b] = [0, 1, 2].map(|c| f64::from(texel[c]) * strength[c]);
                sums = [sums[0] + r, sums[1] + g, sums[2] + b];
                *sum += share * (r + g + b);
            }
            let part = share * (cosines[row] - cosines[row + 1]) * 0.5 / width as f64;
            mean = [0, 1, 2].map(|c| mean[c] + sums[c] * part);
        }
        let cell = |shares: &Vec<(usize, f64)>| shares.iter().map(|(x, share)| line[*x] * share).sum::<f64>();
        (across.iter().map(|shares| cell(shares) * solid_angle).collect::<Vec<f64>>(), mean)
    };
    let mut weights = Vec::with_capacity(rows * columns);
    let mut mean = [0.0f64; 3];
    for (cells, part) in parallel::rows(rows, columns, row) {
        weights.extend(cells);
        mean = [0, 1, 2].map(|c| mean[c] + part[c]);
    }
    (weights, Spectrum(mean.map(|m| m as f32)))
}

/// Weights to choose cells by. What of each cell is above the mean of the sphere: the rest is found as well by scattering, and
/// where both sample, a density that leaves it out has the least variance (Karlik et al., "MIS Compensation: Optimizing Sampling
/// Techniques in Multiple Importance Sampling", 2019). All of it where nothing is above the mean. [`EVEN_SHARE`] of the whole is
/// dealt out to the cells that shine, alike.
fn chosen(mut weights: Vec<f64>, columns: usize, cosines: &[f64]) -> Vec<f64> {
    // Over the solid angle in units of the sphere.
    let mean: f64 = weights.iter().sum();
    let share = |row: usize| 0.5 * (cosines[row] - cosines[row + 1]) / columns as f64;
    let above = |i: usize, w: f64| {
        let excess = w - mean * share(i / columns);
        // Rounding is no light.
        if excess > 1e-9 * w { excess } else { 0.0 }
    };
    let excess: f64 = weights.iter().enumerate().map(|(i, &w)| above(i, w)).sum();
    let total = if excess > 0.0 { excess } else { mean };
    let shining = weights.iter().filter(|w| **w > 0.0).count();
    let even = total * EVEN_SHARE / shining.max(1) as f64;
    for (i, weight) in weights.iter_mut().enumerate().filter(|(_, weight)| **weight > 0.0) {
        let kept = if excess > 0.0 { above(i, *weight) } else { *weight };
        *weight = kept * (1.0 - EVEN_SHARE) + even;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::chosen;

    #[test]
    fn what_is_below_the_mean_is_left_to_scattering() {
        let cosines = [1.0, 0.0, -1.0];
        // Of 8 the four cells have 2 each by their solid angles.
        let found = chosen(vec![1.0, 0.0, 2.0, 5.0], 2, &cosines);
        assert_eq!(found, [0.0625, 0.0, 0.0625, 3.0 * 15.0 / 16.0 + 0.0625]);
        assert_eq!(chosen(vec![1.0; 4], 2, &cosines), [1.0; 4]);
        assert_eq!(chosen(vec![0.0; 4], 2, &cosines), [0.0; 4]);
    }
}
