//! A ray in the space of the primitives it is tested against.

use crate::bounds::greatest;
use crate::geometry::Transform;

/// Coordinates and origins reach at most this far (1.1e15): products of edge functions cannot overflow.
pub(crate) const COORDINATE_LIMIT: f32 = (1_u64 << 50) as f32;

/// The largest component of a direction lies between this (9e-13) and its reciprocal.
const DIRECTION_LIMIT: f32 = 1.0 / (1_u64 << 40) as f32;

/// Origin and direction with the shear that lays the ray on the z axis (Woop, Benthin, Wald 2013): z is the axis of the
/// largest component of the direction, and a point p becomes (p.x - shear.x p.z, p.y - shear.y p.z, shear.z p.z)
/// relative to the origin, where the last is the ray parameter. Unlike the paper's, the axes are not swapped for negative
/// directions, because faces have no back.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalRay {
    pub origin: [f32; 3],
    pub direction: [f32; 3],
    /// Which axes of space are x, y and z of the shear: a permutation of 0, 1, 2.
    pub axes: [usize; 3],
    pub shear: [f32; 3],
}

impl LocalRay {
    /// `None` for a ray that hits nothing by definition: an origin or direction that is not finite or out of range, or a
    /// direction of length 0.
    #[inline(always)]
    pub fn new(origin: [f32; 3], direction: [f32; 3]) -> Option<Self> {
        let major = Self::major_axis(origin, direction)?;
        let axes = [(major + 1) % 3, (major + 2) % 3, major];
        let [dx, dy, dz] = axes.map(|axis| direction[axis]);
        Some(Self { origin, direction, axes, shear: [dx / dz, dy / dz, 1.0 / dz] })
    }

    /// The axis of the direction's largest component; `None` for a ray that hits nothing by definition.
    #[inline(always)]
    pub fn major_axis(origin: [f32; 3], direction: [f32; 3]) -> Option<usize> {
        let (x, y, z) = (direction[0].abs(), direction[1].abs(), direction[2].abs());
        // Without branches: directions are as good as random.
        let (x_first, y_second) = ((x >= y) & (x >= z), y >= z);
        let major = usize::from(!x_first) * (2 - usize::from(y_second));
        // A NaN anywhere makes a comparison false.
        let near = |o: f32| o.abs() <= COORDINATE_LIMIT;
        let in_range = |d: f32| d <= 1.0 / DIRECTION_LIMIT;
        let traceable = near(origin[0])
            & near(origin[1])
            & near(origin[2])
            & in_range(x)
            & in_range(y)
            & in_range(z)
            & (greatest(greatest(x, y), z) >= DIRECTION_LIMIT);
        traceable.then_some(major)
    }

    /// The ray in the space of an instance, with the same parameter t.
    #[inline(always)]
    pub fn in_object(&self, transform: &Transform) -> Option<Self> {
        Self::new(transform.point_to_object(self.origin), transform.vector_to_object(self.direction))
    }

    /// The largest magnitude of the origin's coordinates.
    #[inline(always)]
    pub fn origin_reach(&self) -> f32 {
        let [x, y, z] = self.origin.map(f32::abs);
        greatest(greatest(x, y), z)
    }
}
