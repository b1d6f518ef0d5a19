//! Statistical tests and image comparison for light transport. Takes closures and slices, knows none of our types.
//!
//! * [`chi2`]: does a sampler follow its density?
//! * [`ttest`]: does a mean agree with a reference, or with another mean?
//! * [`tiles`]: do two sets of renderings agree, tile by tile?
//! * [`image`]: how far is a picture from its reference?
//!
//! Everything is f64 and repeatable from a seed.
//! A family of `n` tests at level `alpha` runs each at [`sidak`]`(alpha, n)`.

#![forbid(unsafe_code)]
// The results are compared with levels, never bit by bit, so the platform's functions will do.
#![allow(clippy::disallowed_methods)]

pub mod chi2;
pub mod image;
mod quadrature;
mod rng;
pub mod special;
pub mod tiles;
pub mod ttest;

pub use quadrature::{integrate_1d, integrate_2d};
pub use rng::Rng;
pub use special::sidak;
pub use ttest::Moments;
