//! Scene descriptions, diagnostics and file formats.

#![forbid(unsafe_code)]

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

pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use limits::Limits;
pub use read::{read_scene, read_toml};
pub use source::{FileId, Origin, SourceError, SourceMap, Span};
