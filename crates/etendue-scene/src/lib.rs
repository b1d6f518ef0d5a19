//! Scene descriptions, diagnostics and file formats.

#![forbid(unsafe_code)]

pub mod diagnostic;
pub mod gzip;
pub mod mesh_file;
pub mod mtl;
pub mod obj;
pub mod ply;
mod polygon;
mod positions;
pub mod source;
mod text;

pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use source::{FileId, Origin, SourceError, SourceMap, Span};
