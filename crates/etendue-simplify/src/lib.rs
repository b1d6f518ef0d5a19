//! Mesh simplification: fewer triangles, the same shape. Flat slices in, flat vectors out; no files and no renderer.
//!
//! Edges are collapsed in the order of what that costs, by quadric error metrics (Garland and Heckbert 1997).

mod error;
mod mesh;
mod options;

pub use error::SimplifyError;
pub use mesh::{Mesh, MeshRef};
pub use options::{Keep, Method, Options, Placement, Progress, Stage, Target};
