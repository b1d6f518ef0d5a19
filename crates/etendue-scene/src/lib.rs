//! Scene descriptions, diagnostics and file formats.

#![forbid(unsafe_code)]

pub mod animation;
mod build;
mod content;
mod crease;
pub mod curve;
pub mod description;
pub mod diagnostic;
mod find_file;
pub mod geometry;
pub mod gzip;
pub mod image_file;
pub mod import;
mod indexed;
pub mod keyframes;
mod limits;
pub mod mesh_file;
pub mod mesh_output;
pub mod model_scene;
pub mod mtl;
mod not_yet;
pub mod obj;
pub mod off;
pub mod output;
mod parallel;
pub mod physics;
pub mod ply;
mod polygon;
mod positions;
pub mod read;
pub mod schema;
pub mod script;
pub mod simplify;
pub mod source;
pub mod stl;
pub mod sun_position;
mod text;
pub mod timeline;
pub mod track;
pub mod value;
mod vertex_colors;
pub mod volume_file;
mod weld;
mod write_toml;

pub use build::{Input, build, build_with, scene_hash};
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use limits::Limits;
pub use not_yet::not_read_yet;
pub use read::{ReadError, read_scene, read_toml};
pub use source::{FileId, Origin, SourceError, SourceMap, Span};
