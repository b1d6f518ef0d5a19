//! Lights: every sampler against its density, closed forms of irradiance, the choice among lights, and ugly input.
#![allow(clippy::disallowed_methods)]

mod cases;
mod delta;
mod directions;
mod irradiance;
mod robustness;
mod segments;
mod sky;
mod table;

use etendue::math::{DVec3, Vec3, dvec3};

/// Samples per test: `long` where proofs are asked for by the environment variable `ETENDUE_PROVE`.
fn samples(short: u64, long: u64) -> u64 {
    if std::env::var_os("ETENDUE_PROVE").is_some() { long } else { short }
}

fn double(v: Vec3) -> DVec3 {
    dvec3(v.x.into(), v.y.into(), v.z.into())
}
