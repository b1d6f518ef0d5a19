//! Every BSDF against what must hold for all of them, over several parameter sets each, and against closed forms and
//! f64 references.

#![allow(clippy::disallowed_methods)]

mod cases;
mod energy;
mod furnace;
mod lanes;
mod mixtures;
mod reference;
mod robustness;
mod sampling;
mod symmetry;
mod validation;
