//! Scene descriptions, diagnostics and file formats.

#![forbid(unsafe_code)]

mod build;
pub mod description;
pub mod diagnostic;
pub mod geometry;
mod limits;
pub mod mesh_file;
pub mod output;
mod pending;
pub mod read;
pub mod source;
pub mod value;
pub mod gzip;
pub mod mesh_file;
pub mod mtl;
pub mod obj;
pub mod ply;
mod polygon;
mod positions;
pub mod source;
mod text;

pub use build::{Input, build, scene_hash};
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use limits::Limits;
pub use read::{ReadError, read_scene, read_toml};
pub use source::{FileId, Origin, SourceError, SourceMap, Span};
