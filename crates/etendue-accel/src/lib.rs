//! Ray traversal: triangles, spheres and instances in brute force, a kd-tree and an 8-wide BVH behind one interface
//! that takes slices of rays. A world of few primitives is traced without a tree.
//!
//! Every accelerator calls the same primitive tests and breaks ties by (t, instance, primitive), so all of them give
//! the same hits, bit for bit, on every instruction set.

mod accelerator;
mod bounds;
mod brute;
mod bvh;
mod clip;
mod error;
mod flat;
mod geometry;
mod isa;
mod items;
mod kd;
mod levels;
mod local_ray;
mod memory;
mod motion;
mod nearest;
mod padding;
mod prefetch;
#[cfg(test)]
mod random;
mod ray;
mod search;
mod shared;
mod simd;
mod source;
mod sphere;
mod threads;
mod transform;
mod triangle;

pub use accelerator::{Accelerator, AcceleratorKind, KdTreeSplit, Stats, UnknownAccelerator};
pub use bounds::Bounds;
pub use error::BuildError;
pub use geometry::{Geometry, Instance, Place, Sphere, Transform, TriangleMesh, World};
pub use isa::{Isa, Kernel, UnknownIsa, run};
pub use motion::{Motion, RigidKey};
pub use nearest::{ClosestPoint, ClosestPoints, closest_on_triangle};
pub use prefetch::prefetch;
pub use ray::{Hit, PrimitiveId, Ray};
pub use shared::zeroed_shared;
