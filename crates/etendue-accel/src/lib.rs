//! Ray traversal: triangles, spheres and instances in brute force, a kd-tree and an 8-wide BVH behind one interface
//! that takes slices of rays.
//!
//! Every accelerator calls the same primitive tests and breaks ties by (t, instance, primitive), so all of them give
//! the same hits, bit for bit, on every instruction set.

mod geometry;
mod ray;

pub use geometry::{Geometry, Instance, Sphere, Transform, TriangleMesh, World};
pub use ray::{Hit, PrimitiveId, Ray};
