//! Furnaces and media with bodies that move.

use super::*;
use etendue::{
    integrator::Integrator,
    material::{Scattering, Tangent},
    math::dvec3,
    medium::Medium,
    render::RenderSettings,
    scene::{DeltaLight, Shape},
    spectrum::Spectrum,
};

/// Nothing absorbs, and light of radiance 1 comes from everywhere: 1 in every direction.
#[test]
fn furnaces_stay_white_whatever_moves() {
    let tint = Spectrum::ONE;
    let kinds = [
        Scattering::Diffuse { reflectance: tint, transmittance: Spectrum::BLACK },
        Scattering::Mirror { reflectance: tint },
        Scattering::Glass { ior: 1.5, reflection_tint: tint, transmission_tint: tint, thin: false },
    ];
    for scale in [1e-2, 1.0, 1e3] {
        let mut parts = Parts::default();
        let (body, block) = (parts.shape(ball(2)), parts.shape(cube(false)));
        let sphere = parts.shape(Shape::Sphere { center: DVec3::ZERO, radius: 1.0 });
        for i in 0..9 {
            let material = parts.material(kinds[i % 3]);
            let at = dvec3((i % 3) as f64 - 1.0, (i / 3) as f64 - 1.0, 0.0) * 1.2 * scale;
            let size = if i % 2 == 0 { dvec3(0.4, 0.5, 0.3) } else { DVec3::splat(0.5) };
            let to = DAffine3::from_translation(at) * DAffine3::from_scale(size * scale);
            let end = pose(dvec3(1.0, i as f64, -2.0), 0.4 * i as f64, at, dvec3(0.1, -0.2, 0.3) * scale);
            parts.place_moving([body, block, sphere][i / 3], to, material, between(Pose::IDENTITY, end));
        }
        parts.0.environment = Some(Spectrum::ONE.into());
        let view = camera(dvec3(0.0, 0.0, 6.0) * scale, DVec3::ZERO);
        let scene = parts.build();
        for integrator in SOLVERS {
            let moments = means(&scene, &view, [32, 32], &statistics(integrator, 16), 8);
            assert_mean(&format!("{integrator}, scale {scale}"), &moments, 1.0, 0.002);
        }
    }
}

fn gas(parts: &mut Parts, absorption: f32) -> usize {
    parts.0.media.push(Medium { name: "gas".to_owned(), absorption: Spectrum::splat(absorption), ..Medium::default() });
    let boundary = parts.material(Scattering::Black);
    parts.0.materials[boundary].opacity = 0.0.into();
    parts.0.materials[boundary].interior = Some("gas".to_owned());
    boundary
}

/// A cube of gas that comes from behind the camera, which is in it at last.
#[test]
fn the_camera_is_in_a_body_for_as_long_as_it_is() {
    let absorption = 1.5;
    let mut parts = Parts::default();
    let boundary = gas(&mut parts, absorption);
    let block = parts.shape(cube(false));
    parts.place_moving(block, DAffine3::IDENTITY, boundary, straight(DVec3::Z * 3.0, DVec3::ZERO));
    parts.0.environment = Some(Spectrum::ONE.into());
    let view = CameraSettings {
        projection: Projection::Orthographic { height: 1e-3 },
        ..camera(dvec3(0.1, 0.2, 0.0), dvec3(0.1, 0.2, -1.0))
    };
    // At time 1 - t, 1 - 3 t of gas are before it.
    let k = f64::from(absorption);
    let exact = (1.0 - (-k).exp()) / (3.0 * k) + 2.0 / 3.0;
    let scene = parts.build();
    for integrator in SOLVERS {
        let moments = means(&scene, &view, [16, 16], &statistics(integrator, 16), 16);
        assert_mean(&format!("{integrator}"), &moments, exact, 0.01);
    }
}

/// Gas that shadows come through: light from a lamp through a cube of gas that passes by.
#[test]
fn shadows_pass_through_gas_where_it_is_then() {
    let absorption = 2.0;
    let lit = |motion: Option<Motion>| {
        let mut parts = Parts::default();
        let boundary = gas(&mut parts, absorption);
        let (white, glow) = (parts.diffuse([1.0; 3]), parts.emitter([1.0; 3], false));
        parts.rectangle(dvec3(-0.05, 0.0, -0.05), DVec3::Z * 0.1, DVec3::X * 0.1, white);
        parts.rectangle(dvec3(-0.1, 4.0, -0.1), DVec3::X * 0.2, DVec3::Z * 0.2, glow);
        let block = parts.shape(cube(false));
        if let Some(motion) = motion {
            parts.place_moving(block, DAffine3::from_translation(dvec3(-3.0, 2.5, 0.0)), boundary, motion);
        }
        let view = CameraSettings {
            projection: Projection::Orthographic { height: 0.05 },
            ..camera(dvec3(0.0, 0.5, 0.0), DVec3::ZERO)
        };
        let settings = RenderSettings { max_depth: Some(2), ..statistics(Integrator::LightSplit, 64) };
        means(&parts.build(), &view, [8, 8], &settings, 32)
    };
    // The cube's 2 m take 2 of 8 m to pass every straight way from lamp to plate, nearly upright.
    let found = lit(Some(straight(DVec3::ZERO, DVec3::X * 8.0)));
    let free = lit(None).mean();
    let exact = free * (0.75 + 0.25 * (-2.0 * f64::from(absorption)).exp());
    assert!(found.standard_error() < 0.004 * exact);
    let sigma = (found.mean() - exact) / (found.standard_error() + 0.001 * exact);
    assert!(sigma.abs() < 3.0, "{} not {exact}: {sigma}", found.mean());
}

/// Grooves and texture go along: a turned body looks as the camera, turned the other way, sees it at rest.
#[test]
fn directions_and_textures_go_along() {
    let turn = DQuat::from_axis_angle(dvec3(0.2, 1.0, -0.3).normalize(), 0.7);
    let scene = |motion: Motion, lamp: DQuat| {
        let mut parts = Parts::default();
        let metal = etendue::bsdf::metals::find("gold").expect("a known metal");
        for (i, direction) in [
            Tangent::Uv,
            Tangent::Constant(DVec3::X),
            Tangent::Tangential { center: dvec3(0.0, -0.5, 0.0), axis: Some(DVec3::Y) },
        ]
        .into_iter()
        .enumerate()
        {
            let brushed = parts.material(Scattering::RoughMetal {
                eta: metal.eta,
                k: metal.k,
                alpha: [0.4, 0.05],
                tint: Spectrum::ONE,
            });
            parts.0.materials[brushed].tangent.direction = direction;
            let at = dvec3(1.2 * i as f64 - 1.2, 0.0, 0.0);
            let body = parts.shape(if i == 1 { ball(3) } else { Shape::Sphere { center: DVec3::ZERO, radius: 1.0 } });
            let to = DAffine3::from_translation(at) * DAffine3::from_scale(DVec3::splat(0.5));
            parts.place_moving(body, to, brushed, motion.clone());
        }
        let (position, intensity) = (lamp * dvec3(0.5, 2.0, 3.0), Spectrum::splat(20.0));
        parts.0.delta_lights = vec![DeltaLight::Point { position, intensity }];
        parts.build()
    };
    let view = camera(dvec3(0.0, 0.3, 5.0), DVec3::ZERO);
    let turned =
        CameraSettings { position: turn * view.position, direction: turn * view.direction, up: turn * view.up, ..view };
    let rest = Pose { rotation: turn, translation: DVec3::ZERO };
    let settings = RenderSettings { spp: 64, max_depth: Some(2), ..statistics(Integrator::Path, 64) };
    let at_home =
        interleaved(&picture(&scene(Motion::resting(Pose::IDENTITY), DQuat::IDENTITY), &view, [48, 24], &settings));
    let away = interleaved(&picture(&scene(Motion::resting(rest), turn), &turned, [48, 24], &settings));
    // So little on its way that only the code for what moves differs.
    let on = Pose { rotation: turn, translation: DVec3::X * 1e-9 };
    let moving = interleaved(&picture(&scene(between(rest, on), turn), &turned, [48, 24], &settings));
    for (name, other) in [("at rest", away), ("moving", moving)] {
        let apart: f64 = at_home.iter().zip(&other).map(|(a, b)| f64::from(a - b).abs()).sum();
        let all: f64 = at_home.iter().map(|a| f64::from(*a)).sum();
        assert!(apart < 0.01 * all, "{name}: {apart} of {all}");
    }
}
