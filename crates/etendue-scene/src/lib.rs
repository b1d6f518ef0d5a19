//! Scene descriptions, diagnostics and file formats.
