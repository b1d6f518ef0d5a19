//! Emitters that are partly not there: what light samples find and what rays find must be the same light.

mod common;

use common::*;
use etendue::{
    camera::CameraSettings,
    math::{DVec3, dvec3},
    scene::Scene,
};

const RHO: f32 = 0.8;
const EMITTED: f32 = 2.0;
const OPACITY: f32 = 0.4;

/// A black sphere of radius 0.5 that emits E and is there to the share a, in the middle of a room, a sphere of radius 1 and
/// albedo rho. From each point of the room the lamp covers the share P = 1/4 of the cosine-weighted hemisphere. A ray
/// to it meets the near side, then the far side from inside. It finds F = a E, and (1 - a) a E more if the lamp emits
/// inward too; with probability (1 - a)^2 it goes on to the room. So B = rho (P F + (1 - P + P (1 - a)^2) B).
fn lamp_in_a_room(two_sided: bool) -> (Scene, CameraSettings, f64) {
    let mut parts = Parts::default();
    let wall = parts.diffuse([RHO; 3]);
    let lamp = parts.emitter([EMITTED; 3], two_sided);
    parts.0.materials[lamp].opacity = OPACITY.into();
    parts.sphere(DVec3::ZERO, 1.0, wall);
    parts.sphere(DVec3::ZERO, 0.5, lamp);
    let (rho, e, a, p) = (f64::from(RHO), f64::from(EMITTED), f64::from(OPACITY), 0.25);
    let through = (1.0 - a) * (1.0 - a);
    let found = if two_sided { a * e + (1.0 - a) * a * e } else { a * e };
    let exact = rho * p * found / (1.0 - rho * (1.0 - p + p * through));
    (parts.build(), camera(dvec3(0.0, 0.0, 0.8), dvec3(0.0, 0.5, 1.0)), exact)
}

#[test]
fn a_lamp_that_is_partly_there_lights_a_room_as_derived() {
    for two_sided in [false, true] {
        let (scene, view, exact) = lamp_in_a_room(two_sided);
        for integrator in SOLVERS {
            let moments = means(&scene, &view, [8, 8], &statistics(integrator, 1024), 32);
            assert_mean(&format!("{integrator}, two-sided {two_sided}"), &moments, exact, 0.004);
        }
    }
}
