//! Participating media: phase functions, free flights, transmittance, grids of density.

#![allow(clippy::disallowed_methods)]

mod flights;
mod grids;
mod phase;
