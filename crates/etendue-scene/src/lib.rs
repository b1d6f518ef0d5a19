//! Scene descriptions, diagnostics and file formats.

#![forbid(unsafe_code)]

pub mod diagnostic;
pub mod mesh_file;
pub mod output;
pub mod source;

pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use source::{FileId, Origin, SourceError, SourceMap, Span};
