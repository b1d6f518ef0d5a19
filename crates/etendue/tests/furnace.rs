//! Furnaces: scenes whose radiance is the same everywhere and known.

mod common;

use common::*;
use etendue::{
    integrator::Integrator,
    material::Scattering,
    math::{DAffine3, DQuat, DVec3, dvec3},
    render::RenderSettings,
    sampling::Sampler,
    scene::{Scene, Shape},
    spectrum::Spectrum,
};

const EMITTED: f32 = 0.5;

/// A closed room in which every surface emits and reflects. Radiance is L = E + rho L everywhere: L = E / (1 - rho).
fn closed(room: Shape, rho: f32) -> Scene {
    let mut parts = Parts::default();
    let wall = parts.diffuse([rho; 3]);
    parts.emitting(wall, [EMITTED; 3], true);
    let shape = parts.shape(room);
    parts.place(shape, DAffine3::IDENTITY, wall);
    parts.build()
}

/// A name and what makes the shape.
type Body = (&'static str, fn() -> Shape);

const ROOMS: [Body; 4] =
    [("sphere", unit_sphere), ("cube", || cube(true)), ("ball", || ball(2)), ("drum", || drum(20))];

fn check_closed(rho: f32, spp: u32, (name, room): Body, integrator: Integrator, sampler: Sampler, precision: f64) {
    let view = camera(dvec3(0.1, -0.2, 0.3), dvec3(1.0, 0.3, 0.2));
    let exact = f64::from(EMITTED) / (1.0 - f64::from(rho));
    let settings = RenderSettings { sampler, ..statistics(integrator, spp) };
    let moments = means(&closed(room(), rho), &view, [8, 8], &settings, 16);
    assert_mean(&format!("{name}, rho {rho}, {integrator}, {sampler:?}"), &moments, exact, precision);
}

#[test]
fn closed_furnaces_reach_their_closed_form() {
    for (rho, spp) in [(0.5, 256), (0.8, 768)] {
        for room in ROOMS {
            for integrator in SOLVERS {
                check_closed(rho, spp, room, integrator, Sampler::Independent, 0.001);
            }
        }
    }
}

#[test]
fn a_furnace_of_a_hundred_bounces_reaches_its_closed_form() {
    // Single paths scatter by as much as the mean, and are a hundred edges long: 0.1 % takes a million of them.
    let (spp, precision) = if proving() { (1920, 0.001) } else { (208, 0.003) };
    for (room, integrator) in ROOMS.into_iter().zip(SOLVERS) {
        check_closed(0.99, spp, room, integrator, Sampler::Independent, precision);
    }
}

#[test]
fn closed_furnaces_reach_their_closed_form_with_sobol_points() {
    for (room, integrator) in ROOMS.into_iter().zip(SOLVERS) {
        check_closed(0.8, 512, room, integrator, Sampler::Sobol, 0.001);
    }
}

fn unit_sphere() -> Shape {
    Shape::Sphere { center: DVec3::ZERO, radius: 1.0 }
}

/// What the scales of the tests do to a scene of unit size: as it is, 10^4 times as large, and moved 10 km away.
const PLACES: [(f64, f64); 3] = [(1.0, 0.0), (1e4, 0.0), (1.0, 1e4)];

/// A body under a sky of radiance 1.
fn under_white_sky(
    body: Shape,
    scattering: Scattering,
    scale: f64,
    shift: f64,
) -> (Scene, etendue::camera::CameraSettings) {
    let mut parts = Parts::default();
    let material = parts.material(scattering);
    let shape = parts.shape(body);
    let at = dvec3(shift, -shift, 0.5 * shift);
    parts.place(shape, DAffine3::from_translation(at) * DAffine3::from_scale(DVec3::splat(scale)), material);
    parts.0.environment = Some(Spectrum::ONE.into());
    let view = camera(at + scale * dvec3(2.0, 2.5, 3.0), at);
    (parts.build(), view)
}

fn diffuse(rho: f32) -> Scattering {
    Scattering::Diffuse { reflectance: Spectrum::splat(rho), transmittance: Spectrum::BLACK }
}

#[test]
fn white_bodies_vanish_under_a_white_sky_at_all_scales() {
    let bodies: [Body; 3] = [("sphere", unit_sphere), ("cube", || cube(false)), ("ball", || ball(3))];
    for (scale, shift) in PLACES {
        for (name, body) in bodies {
            let (scene, view) = under_white_sky(body(), diffuse(1.0), scale, shift);
            for integrator in SOLVERS {
                let what = format!("{name}, scale {scale}, shift {shift}, {integrator}");
                let moments = means(&scene, &view, [16, 16], &statistics(integrator, 64), 16);
                assert_mean(&what, &moments, 1.0, 0.001);
            }
        }
    }
}

#[test]
fn a_convex_body_does_not_shadow_itself() {
    // Every path hits the body at most once, so each sample of it is worth exactly rho, of the sky exactly 1.
    let bodies: [Body; 3] = [("sphere", unit_sphere), ("cube", || cube(false)), ("ball", || ball(4))];
    for (scale, shift) in PLACES {
        for (name, body) in bodies {
            let (scene, view) = under_white_sky(body(), diffuse(0.5), scale, shift);
            let image = picture(&scene, &view, [128, 128], &statistics(Integrator::Brute, 4));
            let values = interleaved(&image);
            let wrong = values.iter().filter(|v| (*v * 8.0).fract() != 0.0 || **v < 0.5 || **v > 1.0).count();
            assert_eq!(wrong, 0, "{name}, scale {scale}, shift {shift}: numbers that are no mean of 1/2 and 1");
            assert!(values.contains(&0.5) && values.contains(&1.0), "{name}: both body and sky are seen");
        }
    }
}

#[test]
fn lossless_glass_vanishes_under_a_white_sky() {
    let (ior, tint) = (1.5, Spectrum::ONE);
    let glass = Scattering::Glass { ior, reflection_tint: tint, transmission_tint: tint, thin: false };
    let thin = Scattering::Glass { ior, reflection_tint: tint, transmission_tint: tint, thin: true };
    let bodies: [Body; 3] = [("sphere", unit_sphere), ("cube", || cube(false)), ("ball", || ball(3))];
    for (what, scattering) in [("glass", glass), ("thin glass", thin)] {
        for (name, body) in bodies {
            let (scene, view) = under_white_sky(body(), scattering, 1.0, 0.0);
            for integrator in SOLVERS {
                let moments = means(&scene, &view, [16, 16], &statistics(integrator, 64), 16);
                assert_mean(&format!("{what} {name}, {integrator}"), &moments, 1.0, 0.002);
            }
        }
    }
}

#[test]
fn half_transparent_bodies_vanish_under_a_white_sky() {
    for (scale, shift) in PLACES {
        let (mut parts, at) = (Parts::default(), dvec3(shift, 0.0, 0.0));
        let material = parts.diffuse([1.0; 3]);
        parts.0.materials[material].opacity = 0.4.into();
        for (i, body) in [ball(2), unit_sphere(), cube(false)].into_iter().enumerate() {
            let shape = parts.shape(body);
            let to = DAffine3::from_translation(at + scale * dvec3(1.2 * i as f64 - 1.2, 0.0, 0.0));
            parts.place(shape, to * DAffine3::from_scale(DVec3::splat(0.7 * scale)), material);
        }
        parts.0.environment = Some(Spectrum::ONE.into());
        let scene = parts.build();
        let view = camera(at + scale * dvec3(2.0, 3.0, 5.0), at);
        for integrator in SOLVERS {
            let moments = means(&scene, &view, [16, 16], &statistics(integrator, 64), 16);
            assert_mean(&format!("scale {scale}, shift {shift}, {integrator}"), &moments, 1.0, 0.002);
        }
    }
}

/// A square in many small triangles, tilted so that no two of them lie in exactly one plane.
fn tilted_grid(cells: u32) -> Shape {
    let at = |i: u32| f64::from(i) / f64::from(cells) * 2.0 - 1.0;
    let turn = DQuat::from_rotation_z(0.37) * DQuat::from_rotation_x(0.61);
    let corners = (0..=cells).flat_map(|y| (0..=cells).map(move |x| (x, y)));
    let positions = corners.map(|(x, y)| (turn * dvec3(at(x), at(y), 0.0)).as_vec3().to_array()).collect();
    let index = |x: u32, y: u32| y * (cells + 1) + x;
    let cells = (0..cells).flat_map(|y| (0..cells).map(move |x| (x, y)));
    let faces = cells.flat_map(|(x, y)| {
        let [a, b, c, d] = [index(x, y), index(x + 1, y), index(x + 1, y + 1), index(x, y + 1)];
        [[a, b, c], [a, c, d]]
    });
    mesh(positions, faces.collect())
}

#[test]
fn faces_in_one_place_do_not_shadow_each_other() {
    // A ray that leaves one of two equal surfaces starts in the other: the skip id does not help, only the offset does.
    for (scale, shift) in PLACES {
        for instanced in [false, true] {
            let (mut parts, at) = (Parts::default(), dvec3(shift, -shift, 0.5 * shift));
            let material = parts.material(diffuse(0.5));
            let first = parts.shape(tilted_grid(20));
            let second = if instanced { first } else { parts.shape(tilted_grid(20)) };
            for shape in [first, second] {
                let turn = DAffine3::from_translation(at) * DAffine3::from_rotation_y(0.4);
                parts.place(shape, turn * DAffine3::from_scale(DVec3::splat(scale)), material);
            }
            parts.0.environment = Some(Spectrum::ONE.into());
            let view = camera(at + scale * dvec3(2.0, 2.5, 3.0), at);
            let image = picture(&parts.build(), &view, [128, 128], &statistics(Integrator::Brute, 4));
            let values = interleaved(&image);
            let wrong = values.iter().filter(|v| (*v * 8.0).fract() != 0.0 || **v < 0.5 || **v > 1.0).count();
            assert_eq!(wrong, 0, "scale {scale}, shift {shift}, instanced {instanced}: no mean of 1/2 and 1");
            assert!(values.contains(&0.5), "the surface is seen");
        }
    }
}
