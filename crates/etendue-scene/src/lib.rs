//! Scene descriptions, diagnostics and file formats.

#![forbid(unsafe_code)]

pub mod output;
