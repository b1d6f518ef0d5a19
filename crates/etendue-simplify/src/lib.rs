//! Mesh simplification: fewer triangles, the same shape. Flat slices in, flat vectors out; no files and no renderer.
//!
//! Edges are collapsed in the order of what that costs, by quadric error metrics (Garland and Heckbert 1997).

mod apart;
mod block;
mod bounded;
mod check;
mod cost;
mod curves;
mod cut;
mod distance;
mod draft;
mod engine;
mod error;
mod faces;
mod legal;
mod mesh;
mod metric;
mod options;
mod places;
mod polish;
mod prepare;
mod quadric;
mod queue;
mod report;
mod rings;
mod scale;
mod simplify;
mod surface;
mod upright;
mod vector;
mod vertex;
mod wedges;
mod weld;

pub use check::{Findings, Found, check};
pub use distance::{Distance, OneWay, distance};
pub use error::SimplifyError;
pub use mesh::{Mesh, MeshRef};
pub use metric::SIGMA;
pub use options::{Keep, Method, Options, Placement, Progress, Stage, Target};
pub use report::{Dropped, Report, Simplified, Stopped};
pub use simplify::simplify;
