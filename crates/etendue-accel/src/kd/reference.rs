//! What cells refer to: the part of a primitive inside of a cell, by a box around it.
//!
//! # Why no point of a primitive is lost
//!
//! A reference's box holds every point of its primitive in its closed cell. That is so at the root. When a cell is cut, a reference
//! whose box ends at or below the plane goes on below, where its box lies; one whose box begins at or above the plane, and ends
//! above it, goes on above. If the box lies on both sides, each side gets a box around what a conservative clip leaves of the
//! triangle in that closed half (`clip.rs`), met with the half and the box before, both of which hold those points; if that is empty there
//! are none. So every point of the primitive is in a closed leaf that refers to it.

use crate::bounds::Bounds;
use crate::clip::Polygon;
use crate::error::{BuildError, room};
use crate::items::{Item, ItemKind};
use crate::source::Source;

use super::plane::Cut;

/// A primitive in a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    /// Around the part in the cell.
    pub bounds: Bounds,
    pub item: u32,
}

/// Divides references.
pub(super) struct Splitter<'a> {
    pub items: &'a [Item],
    pub source: Source<'a>,
}

impl Splitter<'_> {
    /// The corners of a triangle; `None` for other items.
    fn corners(&self, item: u32) -> Option<[[f32; 3]; 3]> {
        let id = self.items[item as usize].id();
        if self.source.kind(id) == ItemKind::Triangle { self.source.triangle(id) } else { None }
    }

    /// The references of the two halves of a cell, in their order.
    pub fn split(
        &self,
        references: &[Reference],
        cut: Cut,
        cells: &[Bounds; 2],
    ) -> Result<[Vec<Reference>; 2], BuildError> {
        let (mut below, mut above) = (0, 0);
        for reference in references {
            let (lower, upper) = cut.sides(&reference.bounds);
            below += usize::from(lower);
            above += usize::from(upper);
        }
        let mut halves = [room("references", below)?, room("references", above)?];
        for reference in references {
            match cut.sides(&reference.bounds) {
                (true, true) => {
                    let corners = self.corners(reference.item);
                    for (half, cell) in halves.iter_mut().zip(cells) {
                        let bounds = part(&reference.bounds, corners.as_ref(), cell);
                        if !bounds.is_empty() {
                            half.push(Reference { bounds, ..*reference });
                        }
                    }
                }
                (lower, _) => halves[usize::from(!lower)].push(*reference),
            }
        }
        Ok(halves)
    }
}

/// A box around what a box and a cell both have of a primitive, of whose triangle the corners are given.
fn part(bounds: &Bounds, corners: Option<&[[f32; 3]; 3]>, cell: &Bounds) -> Bounds {
    let bounds = bounds.meet(cell);
    let Some(corners) = corners else { return bounds };
    let mut polygon = Polygon::of(corners);
    for axis in 0..3 {
        if let Some([_, above]) = polygon.cut(axis, f64::from(cell.min[axis])) {
            polygon = above;
        }
        if let Some([below, _]) = polygon.cut(axis, f64::from(cell.max[axis])) {
            polygon = below;
        }
    }
    polygon.bounds(&Bounds::of_points(*corners)).meet(&bounds)
}
