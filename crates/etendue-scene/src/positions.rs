//! From the `f64` coordinates of a file to `f32` about a local origin.

use glam::DVec3;
use std::sync::Arc;

/// Larger coordinates are refused, so that squares of lengths stay finite in `f32`.
pub(crate) const LARGEST: f64 = 1e18;

/// Finite, and not too large to work with.
pub(crate) fn usable(position: DVec3) -> bool {
    // Not true for NaN.
    position.abs().cmple(DVec3::splat(LARGEST)).all()
}

/// Unit length, or zero for what has no direction. What is unit length to within rounding stays as it is, so that normals
/// that were written come back the same.
pub(crate) fn unit_normal(normal: DVec3) -> [f32; 3] {
    let rounded = normal.as_vec3().to_array();
    let square = DVec3::from(rounded.map(f64::from)).length_squared();
    if (square - 1.0).abs() < 4e-7 { rounded } else { normal.normalize_or_zero().as_vec3().to_array() }
}

/// A mesh that lies further away than this many times its size gets a local origin.
const FAR: f64 = 4.0;

/// The smallest box about some points; at first about none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub min: DVec3,
    pub max: DVec3,
}

impl Default for Bounds {
    fn default() -> Self {
        Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY }
    }
}

impl Bounds {
    /// Takes in a point.
    #[inline(always)]
    pub fn add(&mut self, point: DVec3) {
        (self.min, self.max) = (self.min.min(point), self.max.max(point));
    }

    /// Takes in all that another took in.
    pub fn add_all(&mut self, other: &Self) {
        (self.min, self.max) = (self.min.min(other.min), self.max.max(other.max));
    }
}

/// The origin for coordinates within these bounds: on each axis the middle, rounded to `f32`, if the coordinates there are
/// large compared with the mesh, so that `f32` keeps its detail; otherwise exactly zero, so that meshes of several files
/// that meet keep meeting. Zero if there are no points.
pub(crate) fn local_origin(Bounds { min, max }: Bounds) -> DVec3 {
    let size = (max - min).max_element();
    let axis = |min: f64, max: f64| {
        let far = min.abs().max(max.abs()) > FAR * size && size > 0.0;
        if far { f64::from((0.5 * (min + max)) as f32) } else { 0.0 }
    };
    DVec3::new(axis(min.x, max.x), axis(min.y, max.y), axis(min.z, max.z))
}

/// Origin and rounded positions. Equal positions stay equal by bits.
pub(crate) fn localise<I>(positions: I) -> (DVec3, Arc<[[f32; 3]]>)
where
    I: Iterator<Item = DVec3> + Clone,
{
    let mut bounds = Bounds::default();
    positions.clone().for_each(|p| bounds.add(p));
    let origin = local_origin(bounds);
    (origin, positions.map(|p| (p - origin).as_vec3().to_array()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    #[test]
    fn near_meshes_keep_their_coordinates() {
        let points = [dvec3(3.1, -1.0, 0.0), dvec3(4.1, -1.0, 1.0)];
        let (origin, positions) = localise(points.iter().copied());
        assert_eq!(origin, dvec3(f64::from(3.6f32), 0.0, 0.0));
        assert_eq!(positions[1][1..], [-1.0, 1.0]);
        let (origin, positions) = localise(points.map(|p| p - dvec3(2.0, 0.0, 0.0)).into_iter());
        assert_eq!(origin, DVec3::ZERO);
        assert_eq!(positions[0][0], (3.1f64 - 2.0) as f32);
        assert_eq!(localise(std::iter::empty()), (DVec3::ZERO, Arc::from([])));
    }

    #[test]
    fn meshes_ten_kilometres_away_keep_their_detail() {
        let detail = |i: u32| dvec3(10_000.0 + 0.000_1 * f64::from(i), 7_000.0, -12_345.678_9 + 0.000_1 * f64::from(i));
        let points: Vec<DVec3> = (0..10_000).map(detail).collect();
        let (origin, positions) = localise(points.iter().copied());
        for (p, q) in points.iter().zip(positions.iter()) {
            let q = origin + DVec3::from(q.map(f64::from));
            assert!((*p - q).abs().max_element() < 1e-7, "{p} {q}");
        }
    }
}
