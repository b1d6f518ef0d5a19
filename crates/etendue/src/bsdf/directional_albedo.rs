//! How much light a lobe scatters in all, by the angle of one direction: what layers let through to the layers below.
//!
//! The integrals have no closed form. They are summed once, when first asked for, into small tables that are
//! interpolated linearly in the fourth root of the cosine and in a root of the width, which spreads out the steep corner
//! of narrow lobes at grazing angles. The tables are good to 0.01 there, and to 0.003 elsewhere.

use super::{
    ggx::{ALPHA_MIN, Ggx, reflected},
    sheen,
};
use crate::{
    math::{PI, Vec3, sin_cos_turns, vec3},
    parallel,
};
use etendue_accel::{Isa, Kernel, run};
use std::sync::LazyLock;

/// Directional albedo of GGX facets with Schlick's reflectance, `F0 + (1 - F0) (1 - cos)^5`, as a linear function of F0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facets {
    /// Factor of F0.
    pub scale: f32,
    /// What is reflected with F0 = 0.
    pub bias: f32,
}

impl Facets {
    /// The albedo for a normal reflectance.
    #[inline]
    pub fn at(self, f0: f32) -> f32 {
        self.scale * f0 + self.bias
    }

    #[inline]
    fn lerp(self, other: Self, x: f32) -> Self {
        let mix = |a: f32, b: f32| a * (1.0 - x) + b * x;
        Self { scale: mix(self.scale, other.scale), bias: mix(self.bias, other.bias) }
    }
}

/// (1 - cos)^5.
#[inline(always)]
pub fn schlick_weight(cos: f32) -> f32 {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    let m2 = m * m;
    m2 * m2 * m
}

/// Of a facet distribution, or of a mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Width {
    /// Perfectly specular.
    Mirror,
    /// GGX of this row of the table.
    Row(f32),
}

impl Width {
    /// Of a GGX lobe with this alpha; a mirror where [`Ggx::new`] makes none.
    #[inline]
    pub fn of_alpha(alpha: f32) -> Self {
        if alpha < ALPHA_MIN {
            return Self::Mirror;
        }
        let (least, most) = (ALPHA_MIN.sqrt(), 1.0);
        let y = (alpha.sqrt() - least) * (1.0 / (most - least));
        Self::Row(y.clamp(0.0, 1.0).sqrt() * (ROWS - 1) as f32)
    }

    /// Directional albedo at `cos` in [0, 1].
    #[inline]
    pub fn facets(self, cos: f32) -> Facets {
        match self {
            Self::Mirror => {
                let bias = schlick_weight(cos);
                Facets { scale: 1.0 - bias, bias }
            }
            Self::Row(y) => bilinear(&FACETS.at, fourth_root(cos), y, Facets::lerp),
        }
    }

    /// The mean of [`facets`](Self::facets) over the directions of a hemisphere, weighted by their cosine.
    #[inline]
    pub fn average(self) -> Facets {
        match self {
            Self::Mirror => Facets { scale: 20.0 / 21.0, bias: 1.0 / 21.0 },
            Self::Row(y) => {
                let (row, fraction) = cell(y, ROWS);
                FACETS.average[row].lerp(FACETS.average[row + 1], fraction)
            }
        }
    }
}

/// Directional albedo of the unscaled sheen lobe, which may pass 1, at `cos` in [0, 1].
#[inline]
pub fn sheen(cos: f32, alpha: f32) -> f32 {
    let y = (alpha - sheen::ALPHA_MIN) * (1.0 / (1.0 - sheen::ALPHA_MIN));
    let y = y.clamp(0.0, 1.0).sqrt() * (SHEEN_ROWS - 1) as f32;
    bilinear(&SHEEN, fourth_root(cos), y, |a, b, x| a * (1.0 - x) + b * x)
}

const COLUMNS: usize = 40;
const ROWS: usize = 20;
const SHEEN_ROWS: usize = 12;
/// Points along each side of the square that an entry is summed over.
const POINTS: usize = 32;

/// Of facets: at directions, and on average.
struct FacetTables {
    at: [[Facets; COLUMNS]; ROWS],
    average: [Facets; ROWS],
}

static FACETS: LazyLock<FacetTables> = LazyLock::new(|| {
    let least = ALPHA_MIN.sqrt();
    let at = table(|row| {
        let root = least + (1.0 - least) * width(row, ROWS);
        run(Isa::detect(), FacetsOf { alpha: (root * root).max(ALPHA_MIN) })
    });
    FacetTables { average: std::array::from_fn(|row| average(&at[row])), at }
});

static SHEEN: LazyLock<[[f32; COLUMNS]; SHEEN_ROWS]> = LazyLock::new(|| {
    table(|row| {
        let alpha = sheen::ALPHA_MIN + (1.0 - sheen::ALPHA_MIN) * width(row, SHEEN_ROWS);
        std::array::from_fn(|column| sum_sheen(cosine(column), alpha))
    })
});

/// A table over row and cosine. Rows are made on several threads, since the first path that meets the lobe waits for all.
fn table<T: Copy + Send, const N: usize>(of_row: impl Fn(usize) -> [T; COLUMNS] + Sync) -> [[T; COLUMNS]; N] {
    let rows = parallel::map(N, of_row);
    std::array::from_fn(|row| rows[row])
}

/// Of a row, from 0 to 1.
fn width(row: usize, rows: usize) -> f32 {
    let y = row as f32 / (rows - 1) as f32;
    y * y
}

/// Of a column.
fn cosine(column: usize) -> f32 {
    let x = column as f32 / (COLUMNS - 1) as f32;
    ((x * x) * (x * x)).max(1e-5)
}

#[inline]
fn fourth_root(cos: f32) -> f32 {
    cos.clamp(0.0, 1.0).sqrt().sqrt() * (COLUMNS - 1) as f32
}

/// The cell of a coordinate in [0, length - 1], and the place inside.
#[inline]
fn cell(x: f32, length: usize) -> (usize, f32) {
    let index = (x as usize).min(length - 2);
    (index, x - index as f32)
}

#[inline]
fn bilinear<T: Copy, const N: usize>(table: &[[T; COLUMNS]; N], x: f32, y: f32, lerp: fn(T, T, f32) -> T) -> T {
    let ((column, x), (row, y)) = (cell(x, COLUMNS), cell(y, N));
    let along = |row: usize| lerp(table[row][column], table[row][column + 1], x);
    lerp(along(row), along(row + 1), y)
}

/// Midpoints of a grid over the unit square.
fn grid() -> impl Iterator<Item = [f32; 2]> {
    let at = |i: usize| (i as f32 + 0.5) / POINTS as f32;
    (0..POINTS).flat_map(move |i| (0..POINTS).map(move |j| [at(i), at(j)]))
}

/// A direction with this cosine in the plane y = 0.
fn direction(cos: f32) -> Vec3 {
    vec3(((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt(), 0.0, cos)
}

/// A row of the table of facets, all columns at once.
struct FacetsOf {
    alpha: f32,
}

impl Kernel for FacetsOf {
    type Output = [Facets; COLUMNS];

    /// Sums the weights of visible normals, u being 1 less the square of a midpoint because what is lost is lost where
    /// normals are steep, at u near 1.
    #[inline(always)]
    fn run(self) -> [Facets; COLUMNS] {
        let Some(ggx) = Ggx::new(self.alpha, self.alpha) else {
            return std::array::from_fn(|column| Width::Mirror.facets(cosine(column)));
        };
        let mut wo = [Vec3::ZERO; COLUMNS];
        for (column, wo) in wo.iter_mut().enumerate() {
            *wo = direction(cosine(column));
        }
        let (mut all, mut bias) = ([0.0; COLUMNS], [0.0; COLUMNS]);
        for [u, v] in grid() {
            for column in 0..COLUMNS {
                let wo = wo[column];
                let m = ggx.sample_visible(wo, [v, 1.0 - u * u]);
                let wi = reflected(wo, m);
                let weight = ggx.reflection_weight(wo, wi) * (2.0 * u);
                let weight = if wi.z > 0.0 { weight } else { 0.0 };
                all[column] += weight;
                bias[column] += weight * schlick_weight(wo.dot(m));
            }
        }
        let share = 1.0 / (POINTS * POINTS) as f32;
        std::array::from_fn(|i| Facets { scale: (all[i] - bias[i]) * share, bias: bias[i] * share })
    }
}

/// Sums over the hemisphere, z being the square of a midpoint because the integrand is steepest at the horizon.
fn sum_sheen(cos: f32, alpha: f32) -> f32 {
    let wo = direction(cos);
    let mut sum = 0.0;
    for [u, v] in grid() {
        let (sin_phi, cos_phi) = sin_cos_turns(v);
        let z = u * u;
        let radius = (1.0 - z * z).sqrt();
        let wi = vec3(radius * cos_phi, radius * sin_phi, z);
        sum += sheen::lobe(wo, wi, alpha) * (2.0 * u);
    }
    sum * (2.0 * PI / (POINTS * POINTS) as f32)
}

/// Integrates what [`bilinear`] gives along a row: 2 cos dcos with cos = x^4.
fn average(row: &[Facets; COLUMNS]) -> Facets {
    const STEPS: usize = 32 * COLUMNS;
    let mut sum = Facets { scale: 0.0, bias: 0.0 };
    for step in 0..STEPS {
        let x = (step as f32 + 0.5) / STEPS as f32;
        let (column, fraction) = cell(x * (COLUMNS - 1) as f32, COLUMNS);
        let value = row[column].lerp(row[column + 1], fraction);
        let x3 = x * x * x;
        let weight = 8.0 * (x * x3) * x3 / STEPS as f32;
        sum.scale += value.scale * weight;
        sum.bias += value.bias * weight;
    }
    sum
}
