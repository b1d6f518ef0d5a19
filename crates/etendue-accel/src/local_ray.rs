//! A ray in the space of the primitives it is tested against.

use crate::geometry::Place;
use crate::transform::{affine, linear};

/// Coordinates and origins reach at most this far (1.1e15): products of edge functions cannot overflow.
pub(crate) const COORDINATE_LIMIT: f32 = (1_u64 << 50) as f32;

/// The largest component of a direction lies between this (9e-13) and its reciprocal.
pub(crate) const DIRECTION_LIMIT: f32 = 1.0 / (1_u64 << 40) as f32;

/// An axis of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    /// The axes of the shear by the number of the last.
    #[inline(always)]
    pub fn from_major(major: u32) -> [Self; 3] {
        const ORDERS: [[Axis; 3]; 4] = {
            use Axis::{X, Y, Z};
            [[Y, Z, X], [Z, X, Y], [X, Y, Z], [X, Y, Z]]
        };
        ORDERS[major as usize & 3]
    }

    /// Numbers of space along the axes of the shear.
    #[inline(always)]
    pub fn of<T: Copy>(axes: [Self; 3], space: &[T; 3]) -> [T; 3] {
        axes.map(|axis| space[axis as usize])
    }
}

/// Origin and direction with the shear that lays the ray on the z axis (Woop, Benthin, Wald 2013): z is the axis of the
/// largest component of the direction, and a point p becomes (p.x - shear.x p.z, p.y - shear.y p.z, shear.z p.z)
/// relative to the origin, where the last is the ray parameter. Unlike the paper's, the axes are not swapped for negative
/// directions, because faces have no back.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalRay {
    pub origin: [f32; 3],
    pub direction: [f32; 3],
    /// Which axes of space are x, y and z of the shear: a permutation.
    pub axes: [Axis; 3],
    pub shear: [f32; 3],
}

/// The largest magnitude, as bits, which are ordered as the numbers are; NaN is above all.
#[inline(always)]
fn largest([x, y, z]: [u32; 3]) -> u32 {
    x.max(y).max(z)
}

#[inline(always)]
fn magnitudes(v: [f32; 3]) -> [u32; 3] {
    v.map(|x| x.to_bits() & 0x7fff_ffff)
}

impl LocalRay {
    /// No ray.
    pub const NONE: Self =
        Self { origin: [0.0; 3], direction: [0.0; 3], axes: [Axis::X, Axis::Y, Axis::Z], shear: [0.0; 3] };

    /// `None` for a ray that hits nothing by definition: an origin or direction that is not finite or out of range, or a
    /// direction of length 0.
    #[inline(always)]
    pub fn new(origin: [f32; 3], direction: [f32; 3]) -> Option<Self> {
        let (major, is_traceable) = Self::major(origin, direction);
        if !is_traceable {
            return None;
        }
        let axes = Axis::from_major(major);
        let [dx, dy, dz] = Axis::of(axes, &direction);
        // One division of vectors.
        let [x, y, z, _] = [dx, dy, 1.0, 1.0].map(|numerator| numerator / dz);
        Some(Self { origin, direction, axes, shear: [x, y, z] })
    }

    /// The axis of the direction's largest component; `None` for a ray that hits nothing by definition.
    #[inline(always)]
    pub fn major_axis(origin: [f32; 3], direction: [f32; 3]) -> Option<usize> {
        let (major, is_traceable) = Self::major(origin, direction);
        is_traceable.then_some(major as usize)
    }

    /// The axis of the direction's largest component, and false for a ray that hits nothing by definition.
    #[inline(always)]
    pub fn major(origin: [f32; 3], direction: [f32; 3]) -> (u32, bool) {
        const SMALLEST: u32 = DIRECTION_LIMIT.to_bits();
        const GREATEST: u32 = (1.0 / DIRECTION_LIMIT).to_bits();
        let [x, y, z] = magnitudes(direction);
        let across = y.max(z);
        // Without branches: directions are as good as random.
        let major = u32::from(x < across) * (2 - u32::from(y >= z));
        let far = largest(magnitudes(origin)) > COORDINATE_LIMIT.to_bits();
        let longest = x.max(across);
        (major, !far & (SMALLEST..=GREATEST).contains(&longest))
    }

    /// The ray in the space of an instance at a shutter time, with the same parameter t.
    #[inline(always)]
    pub fn inside(&self, place: &Place, time: f32) -> Option<Self> {
        let moving;
        let rows = match place {
            Place::World => return Some(*self),
            Place::Fixed(transform) => &transform.to_object,
            Place::Moving(motion) => {
                moving = motion.to_object_at(time);
                &moving
            }
        };
        Self::new(affine(rows, self.origin), linear(rows, self.direction))
    }

    /// The largest magnitude of the origin's coordinates.
    #[inline(always)]
    pub fn origin_reach(&self) -> f32 {
        f32::from_bits(largest(magnitudes(self.origin)))
    }
}
