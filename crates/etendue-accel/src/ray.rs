//! The records that flow through traversal: a ray in, a small hit out.

/// Names one primitive of one instance.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PrimitiveId {
    /// Index into [`crate::World::instances`].
    pub instance: u32,
    /// Index of the triangle or sphere inside the instance's geometry.
    pub primitive: u32,
}

impl PrimitiveId {
    /// No primitive: the id of a miss, and the `skip` of a ray that starts in free space.
    pub const NONE: Self = Self { instance: u32::MAX, primitive: u32::MAX };
}

/// A ray `origin + t * direction` with `t` in `(t_min, t_max)`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// World space, metres, relative to the scene's centre.
    pub origin: [f32; 3],
    /// Lower end of the range of t, exclusive; at least 0.
    pub t_min: f32,
    /// Unnormalised: one t holds in world and instance space.
    pub direction: [f32; 3],
    /// Upper end of the range of t, exclusive; may be infinite.
    pub t_max: f32,
    /// Shutter time in [0, 1].
    pub time: f32,
    /// Only instances with `instance.mask & ray.mask != 0` are seen.
    pub mask: u32,
    /// The primitive the ray left. A triangle with this id is not tested. A sphere with this id is hit only at its far
    /// side, and only by a ray that goes inward.
    pub skip: PrimitiveId,
}

/// The closest hit of a ray, or a miss (`t` infinite, `id` [`PrimitiveId::NONE`]).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter.
    pub t: f32,
    /// Triangles: weight of the second vertex. Spheres: 0.
    pub u: f32,
    /// Triangles: weight of the third vertex. Spheres: 0.
    pub v: f32,
    /// What was hit.
    pub id: PrimitiveId,
}

impl Hit {
    /// No hit.
    pub const MISS: Self = Self { t: f32::INFINITY, u: 0.0, v: 0.0, id: PrimitiveId::NONE };

    /// True for a real hit.
    #[inline]
    pub fn is_hit(&self) -> bool {
        self.id.instance != u32::MAX
    }
}
