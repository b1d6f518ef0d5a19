//! Scene descriptions, diagnostics and file formats.

#![forbid(unsafe_code)]

mod build;
mod content;
mod crease;
pub mod description;
pub mod diagnostic;
mod find_file;
pub mod geometry;
pub mod gzip;
mod limits;
pub mod mesh_file;
pub mod mtl;
pub mod obj;
pub mod output;
pub mod ply;
mod polygon;
mod positions;
pub mod read;
pub mod source;
mod text;
pub mod value;

pub use build::{Input, build, scene_hash};
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use limits::Limits;
pub use read::{ReadError, read_scene, read_toml};
pub use source::{FileId, Origin, SourceError, SourceMap, Span};
