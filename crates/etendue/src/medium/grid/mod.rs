//! Density that varies over space: voxels in a box, nothing outside.
//!
//! Voxel (i, j, k) has its value in the middle of its cell; between the middles densities are trilinear, and within half a voxel
//! of the box's faces they stay as they are there. Coarse cells of some voxels each know a bound on the density inside.

mod tracking;
mod voxels;
mod walk;

pub(super) use tracking::Track;
pub use voxels::Voxels;

use crate::math::{DAffine3, DVec3, Vec3};
use std::sync::Arc;
use walk::{Piece, Walk};

/// What is no grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GridError {
    /// A side without voxels, or too many.
    #[error("a grid has 1 to {max} voxels a side, not {}", side(*.0), max = DensityGrid::MAX_SIDE)]
    Size([u32; 3]),
    /// Not as many values as voxels.
    #[error("a grid of {} voxels cannot have {count} values", side(*.size))]
    Count {
        /// Voxels along x, y, z.
        size: [u32; 3],
        /// Values given.
        count: usize,
    },
    /// A transform that is singular or not finite.
    #[error("the box of a grid is flat, too large or too small")]
    Transform,
    /// A scale that is negative, not finite, or makes too large a density.
    #[error("the density's scale {0} is negative, not finite, or makes densities above {max:e}", max = Density::LARGEST)]
    Scale(f32),
}

fn side(size: [u32; 3]) -> String {
    size.map(|n| n.to_string()).join(" x ")
}

/// Bounds on the density in coarse cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Block {
    /// No density in the cell is above it.
    majorant: f32,
    /// Of the voxels in the cell.
    mean: f32,
}

/// Voxels, and what is known of them. Immutable; shared by media.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityGrid {
    size: [u32; 3],
    voxels: Voxels,
    /// Voxels along the edge of a coarse cell.
    edge: u32,
    /// Coarse cells along the axes.
    coarse: [u32; 3],
    blocks: Vec<Block>,
    range: [f32; 2],
    mean: f64,
    repaired: u64,
}

impl DensityGrid {
    /// Most voxels along an axis.
    pub const MAX_SIDE: u32 = 1 << 14;

    /// A grid of `size` voxels along x, y and z. Values that are negative or not finite become 0, see [`Self::repaired`]. Beside
    /// the voxels it takes 8 bytes a coarse cell, of which there are at most 64 along an axis.
    ///
    /// # Errors
    /// [`GridError`] if a side is 0 or above [`Self::MAX_SIDE`], or the values are not as many.
    pub fn new(size: [u32; 3], mut voxels: Voxels) -> Result<Self, GridError> {
        if size.iter().any(|n| *n == 0 || *n > Self::MAX_SIDE) {
            return Err(GridError::Size(size));
        }
        let count = voxels.len();
        if size.iter().map(|n| u64::from(*n)).product::<u64>() != count as u64 {
            return Err(GridError::Count { size, count });
        }
        let repaired = voxels.repair();
        let longest = size[0].max(size[1]).max(size[2]);
        let edge = (longest / 16).clamp(4, 8).max(longest.div_ceil(64));
        let coarse = size.map(|n| n.div_ceil(edge));
        let mut grid =
            Self { size, voxels, edge, coarse, blocks: Vec::new(), range: [f32::INFINITY, 0.0], mean: 0.0, repaired };
        grid.survey();
        Ok(grid)
    }

    /// Fills in what is known of the voxels.
    fn survey(&mut self) {
        let [nx, ny, nz] = self.coarse;
        let mut sum = 0.0;
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    let block = self.block_of([i, j, k], &mut sum);
                    self.blocks.push(block);
                }
            }
        }
        self.mean = sum / self.voxels.len() as f64;
    }

    /// One coarse cell; adds its voxels to `total` and the range.
    fn block_of(&mut self, cell: [u32; 3], total: &mut f64) -> Block {
        let [own, reached] = [0, 1].map(|margin| {
            [0, 1, 2].map(|axis| {
                let start = cell[axis] * self.edge;
                (start.saturating_sub(margin), (start + self.edge + margin).min(self.size[axis]))
            })
        });
        let (mut highest, mut sum, mut count) = (0.0f32, 0.0, 0u32);
        for z in reached[2].0..reached[2].1 {
            for y in reached[1].0..reached[1].1 {
                let row_is_own = (own[2].0..own[2].1).contains(&z) && (own[1].0..own[1].1).contains(&y);
                for x in reached[0].0..reached[0].1 {
                    let value = self.voxels.get(self.index([x, y, z]));
                    highest = highest.max(value);
                    if row_is_own && (own[0].0..own[0].1).contains(&x) {
                        sum += f64::from(value);
                        count += 1;
                        self.range = [self.range[0].min(value), self.range[1].max(value)];
                    }
                }
            }
        }
        *total += sum;
        // Interpolation may round up.
        Block { majorant: (highest * (1.0 + 1e-6)).min(f32::MAX), mean: (sum / f64::from(count.max(1))) as f32 }
    }

    #[inline]
    fn index(&self, [x, y, z]: [u32; 3]) -> usize {
        let [nx, ny, _] = self.size.map(|n| n as usize);
        x as usize + nx * (y as usize + ny * z as usize)
    }

    /// Voxels along x, y and z.
    pub fn size(&self) -> [u32; 3] {
        self.size
    }

    /// The values.
    pub fn voxels(&self) -> &Voxels {
        &self.voxels
    }

    /// Least and largest value.
    pub fn range(&self) -> [f32; 2] {
        self.range
    }

    /// Mean value.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Values that were negative or not finite, and are 0 now.
    pub fn repaired(&self) -> u64 {
        self.repaired
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        self.voxels.bytes() + self.blocks.len() * size_of::<Block>()
    }

    /// The density at a point in voxels from the lowest corner; what is outside counts as on the nearest face.
    #[inline]
    fn interpolate(&self, point: DVec3) -> f32 {
        let mut low = [0; 3];
        let mut high = [0; 3];
        let mut share = [0.0; 3];
        for axis in 0..3 {
            let last = self.size[axis] - 1;
            let x = (point[axis] - 0.5).clamp(0.0, f64::from(last));
            low[axis] = x as u32;
            high[axis] = (low[axis] + 1).min(last);
            share[axis] = (x - f64::from(low[axis])) as f32;
        }
        let value = |x, y, z| self.voxels.get(self.index([x, y, z]));
        let row = |y, z| (1.0 - share[0]) * value(low[0], y, z) + share[0] * value(high[0], y, z);
        let slice = |z| (1.0 - share[1]) * row(low[1], z) + share[1] * row(high[1], z);
        (1.0 - share[2]) * slice(low[2]) + share[2] * slice(high[2])
    }

    #[inline]
    fn block(&self, [x, y, z]: [u32; 3]) -> Block {
        let [nx, ny, _] = self.coarse.map(|n| n as usize);
        self.blocks[x as usize + nx * (y as usize + ny * z as usize)]
    }
}

/// A grid placed in space: what multiplies a medium's coefficients.
#[derive(Clone, Debug, PartialEq)]
pub struct Density {
    grid: Arc<DensityGrid>,
    to_world: DAffine3,
    scale: f32,
    /// From points relative to the scene's centre to voxels.
    to_voxels: DAffine3,
}

impl Density {
    /// Largest density, scale included.
    pub const LARGEST: f32 = 1e15;

    /// A grid in the image of the unit cube under `to_world`, metres; its x axis is that of the voxels. `scale`, at least 0, multiplies
    /// the values.
    ///
    /// # Errors
    /// [`GridError`] for a transform that is singular or not finite, or a scale that is negative, not finite, or makes densities
    /// above [`Self::LARGEST`].
    pub fn new(grid: Arc<DensityGrid>, to_world: DAffine3, scale: f32) -> Result<Self, GridError> {
        if !(scale >= 0.0 && scale.is_finite() && grid.range[1] * scale <= Self::LARGEST) {
            return Err(GridError::Scale(scale));
        }
        let placed = Self { grid, to_world, scale, to_voxels: DAffine3::IDENTITY }.relative_to(DVec3::ZERO);
        let usable = to_world.is_finite() && placed.to_voxels.is_finite();
        if usable && to_world.matrix3.determinant() != 0.0 { Ok(placed) } else { Err(GridError::Transform) }
    }

    /// The same with points given relative to `center`, as a scene has them.
    pub fn relative_to(&self, center: DVec3) -> Self {
        let size = DVec3::from_array(self.grid.size.map(f64::from));
        let to_local = DAffine3::from_translation(-center) * self.to_world;
        let to_voxels = DAffine3::from_scale(size) * to_local.inverse();
        Self { grid: self.grid.clone(), to_voxels, ..*self }
    }

    /// The voxels.
    pub fn grid(&self) -> &Arc<DensityGrid> {
        &self.grid
    }

    /// Unit cube to world, metres.
    pub fn to_world(&self) -> DAffine3 {
        self.to_world
    }

    /// Multiplies the values.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// Largest density.
    pub fn largest(&self) -> f32 {
        self.grid.range[1] * self.scale
    }

    /// Density at a point relative to the scene's centre; 0 outside of the box.
    #[inline]
    pub fn at(&self, point: Vec3) -> f32 {
        let point = self.to_voxels.transform_point3(point.as_dvec3());
        let size = DVec3::from_array(self.grid.size.map(f64::from));
        let inside = point.cmpge(DVec3::ZERO).all() && point.cmple(size).all();
        if inside { self.grid.interpolate(point) * self.scale } else { 0.0 }
    }
}

#[cfg(test)]
mod tests;
