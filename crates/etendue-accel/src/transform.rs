//! Affine maps with their inverses.

use crate::bounds::Bounds;
use crate::geometry::Transform;

impl Transform {
    /// The identity.
    pub const IDENTITY: Self = {
        let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        Self { to_world: rows, to_object: rows }
    };

    /// The map with its inverse, computed in f64 by cofactors and rounded once. `None` if an entry is not finite or the
    /// map has no inverse within the range of f32.
    pub fn new(to_world: [[f32; 4]; 3]) -> Option<Self> {
        let m = to_world.map(|row| row.map(f64::from));
        let minor = |r0: usize, c0: usize, r1: usize, c1: usize| m[r0][c0] * m[r1][c1] - m[r0][c1] * m[r1][c0];
        let cofactors = [
            [minor(1, 1, 2, 2), -minor(0, 1, 2, 2), minor(0, 1, 1, 2)],
            [-minor(1, 0, 2, 2), minor(0, 0, 2, 2), -minor(0, 0, 1, 2)],
            [minor(1, 0, 2, 1), -minor(0, 0, 2, 1), minor(0, 0, 1, 1)],
        ];
        let det = m[0][0] * cofactors[0][0] + m[0][1] * cofactors[1][0] + m[0][2] * cofactors[2][0];
        let mut to_object = [[0.0_f32; 4]; 3];
        for (row, cofactor) in to_object.iter_mut().zip(cofactors) {
            let linear = cofactor.map(|x| x / det + 0.0);
            let shift = -(linear[0] * m[0][3] + linear[1] * m[1][3] + linear[2] * m[2][3]);
            *row = [linear[0] as f32, linear[1] as f32, linear[2] as f32, shift as f32 + 0.0];
        }
        let finite = |rows: &[[f32; 4]; 3]| rows.iter().flatten().all(|x| x.is_finite());
        (det != 0.0 && finite(&to_world) && finite(&to_object)).then_some(Self { to_world, to_object })
    }

    /// A point of the object in the world.
    #[inline(always)]
    pub fn point_to_world(&self, p: [f32; 3]) -> [f32; 3] {
        affine(&self.to_world, p)
    }

    /// A vector of the object in the world.
    #[inline(always)]
    pub fn vector_to_world(&self, v: [f32; 3]) -> [f32; 3] {
        linear(&self.to_world, v)
    }

    /// A normal of the object in the world, not of unit length: the transposed inverse.
    #[inline(always)]
    pub fn normal_to_world(&self, n: [f32; 3]) -> [f32; 3] {
        let m = &self.to_object;
        std::array::from_fn(|c| (m[0][c] * n[0] + m[1][c] * n[1]) + m[2][c] * n[2])
    }

    /// A point of the world in the object.
    #[inline(always)]
    pub fn point_to_object(&self, p: [f32; 3]) -> [f32; 3] {
        affine(&self.to_object, p)
    }

    /// A vector of the world in the object.
    #[inline(always)]
    pub fn vector_to_object(&self, v: [f32; 3]) -> [f32; 3] {
        linear(&self.to_object, v)
    }

    /// The determinant of the linear part; negative for a mirror image.
    pub fn determinant(&self) -> f64 {
        let m = self.to_world.map(|row| row.map(f64::from));
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    }

    /// The world box around the image of an object box.
    pub(crate) fn bounds_to_world(&self, bounds: &Bounds) -> Bounds {
        if bounds.is_empty() {
            return Bounds::EMPTY;
        }
        let (mut min, mut max) = ([0.0_f64; 3], [0.0_f64; 3]);
        for (axis, row) in self.to_world.iter().enumerate() {
            (min[axis], max[axis]) = (f64::from(row[3]), f64::from(row[3]));
            for (m, (low, high)) in row.iter().zip(bounds.min.iter().zip(&bounds.max)) {
                let ends = [low, high].map(|x| f64::from(*m) * f64::from(*x));
                min[axis] += ends[0].min(ends[1]);
                max[axis] += ends[0].max(ends[1]);
            }
        }
        Bounds::around(min, max)
    }
}

/// The order of the operations is part of the contract that all accelerators give the same bits.
#[inline(always)]
pub(crate) fn linear(m: &[[f32; 4]; 3], v: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|r| (m[r][0] * v[0] + m[r][1] * v[1]) + m[r][2] * v[2])
}

#[inline(always)]
pub(crate) fn affine(m: &[[f32; 4]; 3], p: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|r| ((m[r][0] * p[0] + m[r][1] * p[1]) + m[r][2] * p[2]) + m[r][3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_undoes() {
        let map = Transform::new([[0.0, -2.0, 0.5, 3.0], [1.0, 0.0, 0.0, -7.0], [0.25, 0.0, -4.0, 1.5]]).unwrap();
        for p in [[1.0, 2.0, 3.0], [-5.0, 0.0, 0.125], [100.0, -3.0, 7.0]] {
            let back = map.point_to_object(map.point_to_world(p));
            assert!((0..3).all(|a| (back[a] - p[a]).abs() <= 1e-4), "{p:?} {back:?}");
            let back = map.vector_to_object(map.vector_to_world(p));
            assert!((0..3).all(|a| (back[a] - p[a]).abs() <= 1e-4), "{p:?} {back:?}");
        }
    }

    #[test]
    fn normals_stay_normal() {
        let map = Transform::new([[1.0, 0.75, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 5.0, 9.0]]).unwrap();
        let (tangent, normal) = ([1.0, 2.0, 0.5], [2.0, -1.0, 0.0]);
        let (t, n) = (map.vector_to_world(tangent), map.normal_to_world(normal));
        assert_eq!(t[0] * n[0] + t[1] * n[1] + t[2] * n[2], 0.0);
        assert_eq!(map.determinant(), 10.0);
    }

    #[test]
    fn without_inverse_there_is_none() {
        let flat = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]];
        let infinite = [[f32::INFINITY, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let nan = [[1.0, 0.0, 0.0, f32::NAN], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        for rows in [flat, infinite, nan] {
            assert_eq!(Transform::new(rows), None);
        }
        assert_eq!(Transform::new(Transform::IDENTITY.to_world), Some(Transform::IDENTITY));
    }

    #[test]
    fn boxes_hold_their_points() {
        let map = Transform::new([[0.6, -0.8, 0.0, 0.1], [0.8, 0.6, 0.0, 1e4], [0.0, 0.0, -3.0, 0.0]]).unwrap();
        let bounds = Bounds { min: [-1.0, 0.1, 2.0], max: [1.0, 0.3, 5.0] };
        let image = map.bounds_to_world(&bounds);
        for i in 0..8 {
            let p = std::array::from_fn(|a| if i >> a & 1 == 0 { bounds.min[a] } else { bounds.max[a] });
            let q = map.point_to_world(p);
            assert!((0..3).all(|a| image.min[a] <= q[a] + 1e-3 && q[a] <= image.max[a] + 1e-3));
        }
        assert!(map.bounds_to_world(&Bounds::EMPTY).is_empty());
    }
}
