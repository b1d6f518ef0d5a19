//! The choice among lights.

use super::{
    cases::{self, Case, RADIANCE},
    double,
    irradiance::{assert_agrees, closed_form, gathered},
    samples,
};
use etendue::{
    bsdf::Density,
    light::{
        ConstantEnvironment, DirectionalLight, Light, LightContext, LightTable, LightTableError, MAX_LIGHTS,
        PointLightSource, SphereLight, TriangleLight,
    },
    math::{DVec3, Vec3},
    spectrum::Spectrum,
};
use etendue_testkit::{Moments, Rng};
use std::f64::consts::PI;

const QUANTA: u32 = 1 << 24;

fn direction(rng: &mut Rng) -> DVec3 {
    DVec3::from(rng.direction())
}

fn small_triangle(rng: &mut Rng) -> Light {
    let at = direction(rng) * rng.range(1.0, 4.0);
    let vertices = [(); 3].map(|()| (at + 0.3 * direction(rng)).as_vec3());
    Light::Triangle(TriangleLight { vertices, radiance: RADIANCE, two_sided: rng.f64() < 0.5 })
}

/// `n` lights of all kinds about the origin.
fn crowd(n: usize, seed: u64) -> Vec<Light> {
    let mut rng = Rng::new(seed);
    let mut lights: Vec<Light> = (0..n)
        .map(|i| {
            let at = (direction(&mut rng) * rng.range(1.0, 4.0)).as_vec3();
            match i % 4 {
                0 => Light::Point(PointLightSource { position: at, intensity: RADIANCE * 0.1 }),
                1 => Light::Sphere(SphereLight::round(at, 0.1 + 0.2 * rng.f32(), RADIANCE)),
                _ => small_triangle(&mut rng),
            }
        })
        .collect();
    if n > 2 {
        lights[n / 2] = Light::Environment(ConstantEnvironment { radiance: RADIANCE * 0.2 });
    }
    lights
}

fn total_probability(table: &LightTable) -> f64 {
    (0..table.lights().len() as u32).map(|i| f64::from(table.probability(i))).sum()
}

/// Every number that a 24-bit selection can be: each light comes up exactly as often as its probability says.
#[test]
fn probabilities_are_exact() {
    for n in [1, 2, 3, 7, 64, 1000, 100_000] {
        let table = LightTable::new(crowd(n, n as u64), 4.0).unwrap();
        let mut counts = vec![0u32; n];
        for quantum in 0..QUANTA {
            counts[table.select(quantum as f32 / QUANTA as f32).unwrap() as usize] += 1;
        }
        for (i, count) in counts.iter().enumerate() {
            assert_eq!(*count as f32 / QUANTA as f32, table.probability(i as u32), "light {i} of {n}");
        }
        assert_eq!(total_probability(&table), 1.0);
    }
}

#[test]
fn lights_are_chosen_by_power() {
    let lights: Vec<Light> = crowd(500, 1).into_iter().filter(|l| !matches!(l, Light::Environment(_))).collect();
    let table = LightTable::new(lights.clone(), 4.0).unwrap();
    let total: f64 = lights.iter().map(|l| l.power(4.0)).sum();
    for (i, light) in lights.iter().enumerate() {
        let (share, got) = (light.power(4.0) / total, f64::from(table.probability(i as u32)));
        assert!((share - got).abs() < 502.0 / f64::from(QUANTA), "light {i}: {share} but {got}");
    }
}

#[test]
fn power_of_each_kind() {
    let mean = (2.0 + 3.0 + 5.0) / 3.0;
    let pi = PI;
    let vertices = [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 3.0, 0.0)];
    let triangle = |two_sided| Light::Triangle(TriangleLight { vertices, radiance: RADIANCE, two_sided });
    let sphere = Light::Sphere(SphereLight::round(Vec3::ONE, 2.0, RADIANCE));
    let point = Light::Point(PointLightSource { position: Vec3::ONE, intensity: RADIANCE });
    let environment = Light::Environment(ConstantEnvironment { radiance: RADIANCE });
    let expected = [
        (triangle(false), pi * 3.0),
        (triangle(true), pi * 6.0),
        (sphere, pi * 16.0 * pi),
        (point, 4.0 * pi),
        (environment, pi * 4.0 * pi * 9.0),
    ];
    for (light, etendue) in expected {
        assert!((light.power(3.0) / (etendue * mean) - 1.0).abs() < 1e-12, "{light:?}");
    }
}

/// Density of a sample against the density of its direction, choice included, and point lights discrete.
#[test]
fn densities_include_the_choice() {
    let table = LightTable::new(crowd(200, 2), 4.0).unwrap();
    let ctx = LightContext { point: Vec3::new(0.1, 0.2, 0.3), normal: Vec3::Y, transmits: true };
    let mut rng = Rng::new(1);
    for _ in 0..20_000 {
        let (select, u) = (rng.f32(), rng.f32x2());
        let index = table.select(select).unwrap();
        let Some(sample) = table.sample(&ctx, select, u) else { continue };
        let light = &table.lights()[index as usize];
        let distance = sample.target.map_or(f32::INFINITY, |t| t.distance(ctx.point));
        let pdf = match light {
            Light::Environment(_) => table.pdf_environment(&ctx, sample.wi),
            _ => table.pdf_hit(&ctx, index, sample.wi, distance),
        };
        match (light, sample.density) {
            (Light::Point(_), Density::Discrete(p)) => assert!(p == table.probability(index) && pdf == 0.0),
            (_, Density::SolidAngle(d)) => assert!((pdf / d - 1.0).abs() < 1e-5, "{light:?}: {d} {pdf}"),
            wrong => panic!("{wrong:?}"),
        }
    }
}

/// The estimate over a table is that of the sum of all lights.
#[test]
fn irradiance_of_many_lights() {
    let point = Vec3::new(0.1, -0.2, 0.3);
    for (test, n) in [2, 3, 10, 100, 3000].into_iter().enumerate() {
        let lights = crowd(n, 40 + n as u64);
        let ctx = LightContext { point, normal: Vec3::new(0.6, 0.0, 0.8), transmits: false };
        let normal = double(ctx.normal);
        let expected: f64 = lights
            .iter()
            .map(|light| {
                let scale = f64::from(light.radiance()[0] / RADIANCE[0]);
                let is_unit = matches!(light, Light::Point(_) | Light::Environment(_));
                closed_form(light, point, normal) * if is_unit { 1.0 } else { scale }
            })
            .sum();
        let table = LightTable::new(lights, 4.0).unwrap();
        let mut rng = Rng::new(test as u64);
        let estimate: Moments = (0..samples(100_000, 3_000_000))
            .map(|_| gathered(table.sample(&ctx, rng.f32(), rng.f32x2()), normal))
            .collect();
        assert_agrees(&estimate, expected, expected, 5, &format!("{n} lights"));
        assert!(estimate.standard_error() < 0.02 * expected, "{n} lights: the test is blunt");
    }
}

/// A large rectangle as a million triangles is as bright as in one piece.
#[test]
fn a_million_lights() {
    const SIDE: usize = 708;
    let corner = |i: usize, j: usize| Vec3::new(i as f32 / SIDE as f32 - 0.5, j as f32 / SIDE as f32 - 0.5, 1.0);
    let mut lights = Vec::with_capacity(2 * SIDE * SIDE);
    for i in 0..SIDE {
        for j in 0..SIDE {
            let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
            for vertices in [[a, b, c], [a, c, d]] {
                lights.push(Light::Triangle(TriangleLight { vertices, radiance: RADIANCE, two_sided: false }));
            }
        }
    }
    let whole = etendue::light::RectangleLight {
        corner: corner(0, 0),
        u: Vec3::Y,
        v: Vec3::X,
        radiance: RADIANCE,
        two_sided: false,
    };
    let ctx = LightContext { point: Vec3::new(0.2, 0.1, 0.3), normal: Vec3::new(0.6, 0.0, 0.8), transmits: false };
    let expected = closed_form(&Light::Rectangle(whole), ctx.point, double(ctx.normal));
    let table = LightTable::new(lights, 2.0).unwrap();
    assert_eq!(total_probability(&table), 1.0);
    let mut rng = Rng::new(1);
    let estimate: Moments = (0..samples(300_000, 10_000_000))
        .map(|_| gathered(table.sample(&ctx, rng.f32(), rng.f32x2()), double(ctx.normal)))
        .collect();
    assert_agrees(&estimate, expected, expected, 1, "a million triangles");
}

/// Degenerate lights keep their index, and are never chosen.
#[test]
fn degenerate_lights_are_left_out() {
    let triangle = |vertices, radiance| Light::Triangle(TriangleLight { vertices, radiance, two_sided: true });
    let good = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let lights = vec![
        triangle([Vec3::ONE; 3], RADIANCE),
        triangle(good, RADIANCE),
        triangle([Vec3::ZERO, Vec3::X, Vec3::X * 2.0], RADIANCE),
        triangle([Vec3::ZERO, Vec3::X, Vec3::splat(f32::NAN)], RADIANCE),
        triangle(good, Spectrum::BLACK),
        triangle(good, Spectrum::splat(f32::NAN)),
        triangle(good, Spectrum::splat(f32::INFINITY)),
        Light::Sphere(SphereLight::round(Vec3::ZERO, 0.0, RADIANCE)),
        Light::Point(PointLightSource { position: Vec3::splat(f32::INFINITY), intensity: RADIANCE }),
    ];
    let only_bad: Vec<Light> = lights.iter().filter(|l| **l != lights[1]).cloned().collect();
    let table = LightTable::new(lights, 1.0).unwrap();
    assert_eq!(table.probability(1), 1.0);
    assert_eq!(total_probability(&table), 1.0);
    let ctx = LightContext { point: Vec3::Z, normal: Vec3::Z, transmits: true };
    assert_eq!(table.pdf_hit(&ctx, 0, Vec3::NEG_Z, 1.0), 0.0);
    assert_eq!(table.pdf_hit(&ctx, 4, Vec3::NEG_Z, 1.0), 0.0);
    assert_eq!(table.pdf_hit(&ctx, u32::MAX, Vec3::NEG_Z, 1.0), 0.0);
    for empty in [LightTable::default(), LightTable::new(only_bad, 1.0).unwrap()] {
        assert!(empty.is_empty() && empty.environment().is_none());
        assert!(empty.select(0.5).is_none() && empty.sample(&ctx, 0.5, [0.5; 2]).is_none());
        assert_eq!((empty.probability(0), empty.pdf_environment(&ctx, Vec3::Z)), (0.0, 0.0));
        assert_eq!(empty.environment_radiance(Vec3::Z), Spectrum::BLACK);
    }
}

/// Lights at infinity leave half of the choices to other lights however large the scene; there is one environment.
#[test]
fn lights_at_infinity() {
    let environment = |radiance| Light::Environment(ConstantEnvironment { radiance });
    let lamp = Light::Point(PointLightSource { position: Vec3::Y, intensity: Spectrum::splat(1e-3) });
    let sun = Light::Directional(DirectionalLight { direction: Vec3::NEG_Y, irradiance: Spectrum::splat(PI as f32) });
    let sky = environment(Spectrum([1.0, 2.0, 3.0]));
    let table = LightTable::new(vec![lamp.clone(), sun, sky.clone()], 1e6).unwrap();
    assert_eq!((table.environment(), table.environment_radiance(Vec3::X)), (Some(2), Spectrum([1.0, 2.0, 3.0])));
    // A sun of pi W m^-2 has pi^2 R^2 W, a sky of radiance 2 has 8 pi^2 R^2 W.
    for (index, share) in [(0, 0.5), (1, 0.5 / 9.0), (2, 4.0 / 9.0)] {
        assert!((table.probability(index) - share).abs() < 1e-6, "light {index}: {}", table.probability(index));
    }
    let alone = LightTable::new(vec![environment(RADIANCE)], 0.0).unwrap();
    assert_eq!(alone.probability(0), 1.0);
    let two = LightTable::new(vec![sky, lamp, environment(RADIANCE)], 1.0);
    assert_eq!(two.err(), Some(LightTableError::SeveralEnvironments));
}

/// Same bits: the choice and the sample are a function of their arguments alone.
#[test]
fn a_table_is_deterministic() {
    let (a, b) = (LightTable::new(crowd(777, 3), 4.0).unwrap(), LightTable::new(crowd(777, 3), 4.0).unwrap());
    let mut rng = Rng::new(7);
    for Case { ctx, .. } in cases::without_surface() {
        let (select, u) = (rng.f32(), rng.f32x2());
        assert_eq!(format!("{:?}", a.sample(&ctx, select, u)), format!("{:?}", b.sample(&ctx, select, u)));
    }
}

/// The full number of lights takes most of a gigabyte: only where proofs are asked for.
#[test]
fn too_many_lights_are_refused() {
    if samples(0, 1) == 1 {
        let lights = vec![Light::Environment(ConstantEnvironment { radiance: RADIANCE }); MAX_LIGHTS + 1];
        assert_eq!(LightTable::new(lights, 1.0).err(), Some(LightTableError::TooMany { count: MAX_LIGHTS + 1 }));
    }
}
