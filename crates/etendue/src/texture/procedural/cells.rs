//! Checker boards and grids of lines, filtered exactly: means over the box about the footprint.

use super::{Function, Place, periodic};
use crate::math::Vec3;

/// Squares of texture coordinates or cubes of space in turn: 0 in the cell from (0, 0, 0) to (1, 1, 1), 1 in its neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checker;

/// 1 on lines (planes, of space) about whole coordinates, 0 between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Width of a line, cells, in [0, 1].
    pub width: f32,
}

impl Grid {
    /// One tenth of a cell.
    pub const DEFAULT: Self = Self { width: 0.1 };
}

/// The coordinates that count, each with the extent of the footprint along it.
#[inline]
fn coordinates(place: &Place) -> impl Iterator<Item = (f32, f32)> {
    let all = [(place.point.x, Vec3::X), (place.point.y, Vec3::Y), (place.point.z, Vec3::Z)];
    let extents = all.map(|(x, axis)| (x, place.extent(axis)));
    extents.into_iter().take(if place.is_solid { 3 } else { 2 })
}

impl Function for Checker {
    fn value(&self, place: &Place) -> f32 {
        // Of coordinates' waves of 1 and -1, the product is that of the board; so is that of their means over a box.
        let wave = |(x, width): (f32, f32)| {
            periodic::mean(
                0.5 * x,
                0.5 * width,
                |x| if x < 0.5 { 1.0 } else { -1.0 },
                |x| if x < 0.5 { x } else { 1.0 - x },
            )
        };
        0.5 - 0.5 * coordinates(place).map(wave).product::<f32>()
    }

    fn finest(&self) -> f32 {
        1.0 / 64.0
    }
}

impl Function for Grid {
    fn value(&self, place: &Place) -> f32 {
        let line = self.width;
        let free = |(x, width): (f32, f32)| {
            let covered = periodic::mean(x + 0.5 * line, width, |x| f32::from(u8::from(x < line)), |x| x.min(line));
            1.0 - covered
        };
        1.0 - coordinates(place).map(free).product::<f32>()
    }

    fn finest(&self) -> f32 {
        (self.width * (1.0 / 8.0)).clamp(1e-3, 1.0 / 64.0)
    }
}
