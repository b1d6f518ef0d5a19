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
        ConstantEnvironment, DirectionalLight, DiskLight, Light, LightContext, LightTable, LightTableError,
        PointLightSource, RectangleLight, RoundOutline, Selected, SphereLight, TriangleLight,
    },
    math::{DVec3, Vec3},
    medium::Segment,
    spectrum::Spectrum,
};
use etendue_testkit::{Moments, Rng, chi2::ChiSquare};
use std::{f64::consts::PI, sync::Arc};

fn direction(rng: &mut Rng) -> DVec3 {
    DVec3::from(rng.direction())
}

fn small_triangle(rng: &mut Rng) -> Light {
    let at = direction(rng) * rng.range(1.0, 4.0);
    let vertices = [(); 3].map(|()| (at + 0.3 * direction(rng)).as_vec3());
    Light::Triangle(TriangleLight { vertices, radiance: RADIANCE, two_sided: rng.f64() < 0.5 })
}

fn small_disk(rng: &mut Rng) -> Light {
    let (center, normal) = (direction(rng) * rng.range(1.0, 4.0), direction(rng));
    let x = normal.any_orthonormal_vector();
    let (y, radius) = (normal.cross(x), rng.range(0.05, 0.4));
    let corner = |i: u32| {
        let (sin, cos) = (2.0 * PI * f64::from(i) / 2000.0).sin_cos();
        center + (x * cos + y * sin) * radius
    };
    let outline = RoundOutline::new(&(0..2000).map(corner).collect::<Vec<_>>()).expect("is round");
    Light::Disk(Arc::new(DiskLight { outline, radiance: RADIANCE, two_sided: rng.f64() < 0.5 }))
}

/// `n` lights of all kinds about the origin.
fn crowd(n: usize, seed: u64) -> Vec<Light> {
    let mut rng = Rng::new(seed);
    let mut lights: Vec<Light> = (0..n)
        .map(|i| {
            let at = (direction(&mut rng) * rng.range(1.0, 4.0)).as_vec3();
            match i % 5 {
                0 => Light::Point(PointLightSource { position: at, intensity: RADIANCE * 0.1 }),
                1 => Light::Sphere(SphereLight::round(at, 0.1 + 0.2 * rng.f32(), RADIANCE)),
                2 => small_disk(&mut rng),
                _ => small_triangle(&mut rng),
            }
        })
        .collect();
    if n > 2 {
        lights[n / 2] = Light::Environment(ConstantEnvironment { radiance: RADIANCE * 0.2 });
    }
    lights
}

/// Contexts of all kinds in and about the crowd.
fn contexts() -> Vec<LightContext> {
    let mut rng = Rng::new(99);
    let gathers = [(true, false), (true, true), (false, true)];
    (0..12)
        .map(|i| {
            let (surface, transmits) = gathers[i % 3];
            let point = (direction(&mut rng) * rng.range(0.0, 6.0)).as_vec3();
            let normal = if surface { direction(&mut rng).as_vec3() } else { Vec3::ZERO };
            LightContext { point, normal, transmits, time: 0.0 }
        })
        .collect()
}

fn probabilities(table: &LightTable, ctx: &LightContext) -> Vec<f64> {
    (0..table.lights().len() as u32).map(|i| f64::from(table.probability(ctx, i))).collect()
}

fn total_probability(table: &LightTable, ctx: &LightContext) -> f64 {
    probabilities(table, ctx).iter().sum()
}

/// Each light comes up as often as its probability says, and what is stated with a choice is its probability.
#[test]
fn selection_follows_its_probabilities() {
    let mut tests = 0;
    for n in [1, 2, 3, 7, 9, 64, 1000] {
        let table = LightTable::new(crowd(n, n as u64), 4.0).unwrap();
        for ctx in contexts() {
            let stated = probabilities(&table, &ctx);
            let total: f64 = stated.iter().sum();
            if total == 0.0 {
                assert!((0..100).all(|i| table.select(&ctx, f64::from(i) / 100.0).is_none()));
                continue;
            }
            // Below 1 where a cluster looked brighter from afar than its parts.
            assert!(total < 1.0 + 1e-5 && total > 0.3, "{n} lights from {ctx:?}: {total}");
            tests += 1;
            let outcome =
                ChiSquare::new(samples(20_000, 2_000_000)).seed(n as u64 + 1000 * tests).indices(&stated, |rng| {
                    let chosen = table.select(&ctx, rng.f64())?;
                    assert_eq!(chosen.probability, table.probability(&ctx, chosen.index));
                    Some(chosen.index as usize)
                });
            outcome.assert(1e-3, 7 * contexts().len(), &format!("{n} lights from {ctx:?}"));
        }
    }
    assert!(tests > 60);
}

/// As above, for lights chosen along segments.
#[test]
fn selection_along_segments_follows_its_probabilities() {
    let table = LightTable::new(crowd(300, 5), 4.0).unwrap();
    let mut rng = Rng::new(3);
    for test in 0..6 {
        let origin = (direction(&mut rng) * rng.range(0.0, 6.0)).as_vec3();
        let length = if test % 2 == 0 { 3.0 } else { f32::INFINITY };
        let segment = Segment { origin, direction: direction(&mut rng).as_vec3(), length };
        let stated: Vec<f64> = (0..300).map(|i| f64::from(table.probability_along(&segment, i))).collect();
        // All but the environment can be chosen.
        assert_eq!(stated.iter().filter(|p| **p == 0.0).count(), 1);
        let outcome = ChiSquare::new(samples(20_000, 2_000_000)).seed(test).indices(&stated, |rng| {
            let chosen = table.select_along(&segment, rng.f64())?;
            assert_eq!(chosen.probability, table.probability_along(&segment, chosen.index));
            Some(chosen.index as usize)
        });
        outcome.assert(1e-3, 6, &format!("{segment:?}"));
    }
}

/// Whatever brings light to a point may be chosen there: for every kind of light and way to gather, alone with one other light
/// and in a crowd.
#[test]
fn no_light_that_shines_is_left_out() {
    let mut rng = Rng::new(8);
    let mut shining = 0;
    for Case { name, light, ctx } in cases::all() {
        let far_off = Light::Point(PointLightSource { position: Vec3::splat(3e5), intensity: RADIANCE });
        let mut lights = vec![far_off; 20];
        lights.push(light.clone());
        for lights in [lights[19..].to_vec(), lights] {
            let index = lights.len() as u32 - 1;
            let table = LightTable::new(lights, 4.0).unwrap();
            let probability = table.probability(&ctx, index);
            for _ in 0..40 {
                let Some(sample) = light.sample(&ctx, rng.f32x2()) else { continue };
                let cos = ctx.normal.dot(sample.wi);
                let taken = ctx.normal == Vec3::ZERO || ctx.transmits || cos > 0.0;
                // An even sky is left to what transmits.
                let even = matches!(light, Light::Environment(_)) && (ctx.transmits || ctx.normal == Vec3::ZERO);
                shining += u32::from(taken && !even);
                assert!(!taken || even || probability > 0.0, "{name}: cosine {cos}");
            }
        }
    }
    assert!(shining > 10_000, "{shining}");
}

/// Among a thousand scattered lamps one choice says nearly all: importance follows what arrives within a small factor, for clusters
/// of any size.
#[test]
fn scattered_lamps_have_little_variance() {
    let mut rng = Rng::new(21);
    let lights: Vec<Light> = (0..1000)
        .map(|_| {
            let at = Vec3::new(rng.range(-6.0, 6.0) as f32, rng.range(0.3, 3.8) as f32, rng.range(-6.0, 6.0) as f32);
            let vertices = [(); 3].map(|()| at + (0.02 * direction(&mut rng)).as_vec3());
            Light::Triangle(TriangleLight { vertices, radiance: RADIANCE, two_sided: false })
        })
        .collect();
    let table = LightTable::new(lights, 8.0).unwrap();
    for _ in 0..20 {
        let point = Vec3::new(rng.range(-4.0, 4.0) as f32, 0.0, rng.range(-4.0, 4.0) as f32);
        let ctx = LightContext { point, normal: Vec3::Y, transmits: false, time: 0.0 };
        let estimate: Moments =
            (0..4000).map(|_| gathered(table.sample(&ctx, rng.f64(), rng.f32x2()), DVec3::Y)).collect();
        // Choices by power alone would have a relative variance above 20.
        let relative = estimate.variance() / (estimate.mean() * estimate.mean());
        assert!(relative < 4.0, "relative variance {relative} at {point}");
    }
}

/// Near lights that face the point are chosen more often than others of the same power.
#[test]
fn choices_go_where_light_comes_from() {
    let facing = |at: Vec3, down: bool| {
        let (u, v) = if down { (Vec3::X, Vec3::Z) } else { (Vec3::Z, Vec3::X) };
        let (u, v) = (u * 0.1, v * 0.1);
        Light::Rectangle(RectangleLight { corner: at, u, v, radiance: RADIANCE, two_sided: false })
    };
    let table = |lights| LightTable::new(lights, 10.0).unwrap();
    let ctx = LightContext { point: Vec3::ZERO, normal: Vec3::Y, transmits: false, time: 0.0 };
    let share = |lights| table(lights).probability(&ctx, 0);
    // Five times as far: 1/25 of the light; the other way round: none, but for the slack of bounds.
    let far = share(vec![facing(Vec3::Y, true), facing(Vec3::Y * 5.0, true)]);
    assert!((far - 25.0 / 26.0).abs() < 0.01, "{far}");
    assert_eq!(share(vec![facing(Vec3::Y, true), facing(Vec3::Y, false)]), 1.0);
    assert_eq!(share(vec![facing(Vec3::Y, true), facing(Vec3::NEG_Y, true)]), 1.0);
}

#[test]
fn power_of_each_kind() {
    let mean = (2.0 + 3.0 + 5.0) / 3.0;
    let pi = PI;
    let vertices = [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 3.0, 0.0)];
    let triangle = |two_sided| Light::Triangle(TriangleLight { vertices, radiance: RADIANCE, two_sided });
    let rim = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0].map(|i: f64| {
        let (sin, cos) = (0.25 * PI * i).sin_cos();
        DVec3::new(cos, sin, 5.0)
    });
    let octagon = |two_sided| {
        let outline = RoundOutline::new(&rim).expect("is round");
        Light::Disk(Arc::new(DiskLight { outline, radiance: RADIANCE, two_sided }))
    };
    let sphere = Light::Sphere(SphereLight::round(Vec3::ONE, 2.0, RADIANCE));
    let point = Light::Point(PointLightSource { position: Vec3::ONE, intensity: RADIANCE });
    let environment = Light::Environment(ConstantEnvironment { radiance: RADIANCE });
    let expected = [
        (triangle(false), pi * 3.0),
        (triangle(true), pi * 6.0),
        (octagon(false), pi * 2.0 * 2f64.sqrt()),
        (octagon(true), pi * 4.0 * 2f64.sqrt()),
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
    let ctx = LightContext { point: Vec3::new(0.1, 0.2, 0.3), normal: Vec3::Y, transmits: true, time: 0.0 };
    let mut rng = Rng::new(1);
    for _ in 0..20_000 {
        let (select, u) = (rng.f64(), rng.f32x2());
        let Some(Selected { index, .. }) = table.select(&ctx, select) else { continue };
        let Some(sample) = table.sample(&ctx, select, u) else { continue };
        let light = &table.lights()[index as usize];
        let distance = sample.target.map_or(f32::INFINITY, |t| t.distance(ctx.point));
        let pdf = match light {
            Light::Environment(_) => table.pdf_environment(&ctx, sample.wi),
            _ => table.pdf_hit(&ctx, index, sample.wi, distance),
        };
        match (light, sample.density) {
            (Light::Point(_), Density::Discrete(p)) => assert!(p == table.probability(&ctx, index) && pdf == 0.0),
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
        let ctx = LightContext { point, normal: Vec3::new(0.6, 0.0, 0.8), transmits: false, time: 0.0 };
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
            .map(|_| gathered(table.sample(&ctx, rng.f64(), rng.f32x2()), normal))
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
    let whole = RectangleLight { corner: corner(0, 0), u: Vec3::Y, v: Vec3::X, radiance: RADIANCE, two_sided: false };
    let ctx =
        LightContext { point: Vec3::new(0.2, 0.1, 0.3), normal: Vec3::new(0.6, 0.0, 0.8), transmits: false, time: 0.0 };
    let expected = closed_form(&Light::Rectangle(whole), ctx.point, double(ctx.normal));
    let table = LightTable::new(lights, 2.0).unwrap();
    assert!((total_probability(&table, &ctx) - 1.0).abs() < 1e-3);
    let mut rng = Rng::new(1);
    let estimate: Moments = (0..samples(300_000, 10_000_000))
        .map(|_| gathered(table.sample(&ctx, rng.f64(), rng.f32x2()), double(ctx.normal)))
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
    let ctx = LightContext { point: Vec3::Z, normal: Vec3::Z, transmits: true, time: 0.0 };
    assert_eq!(table.probability(&ctx, 1), 1.0);
    assert_eq!(total_probability(&table, &ctx), 1.0);
    assert!((0..9).all(|i| table.may_choose(i) == (i == 1)));
    assert_eq!(table.pdf_hit(&ctx, 0, Vec3::NEG_Z, 1.0), 0.0);
    assert_eq!(table.pdf_hit(&ctx, 4, Vec3::NEG_Z, 1.0), 0.0);
    assert_eq!(table.pdf_hit(&ctx, u32::MAX, Vec3::NEG_Z, 1.0), 0.0);
    for empty in [LightTable::default(), LightTable::new(only_bad, 1.0).unwrap()] {
        assert!(empty.is_empty() && empty.environment().is_none());
        assert!(empty.select(&ctx, 0.5).is_none() && empty.sample(&ctx, 0.5, [0.5; 2]).is_none());
        assert_eq!((empty.probability(&ctx, 0), empty.pdf_environment(&ctx, Vec3::Z)), (0.0, 0.0));
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
    // What transmits finds an even sky by itself.
    let surface = LightContext { point: Vec3::ZERO, normal: Vec3::Y, transmits: false, time: 0.0 };
    let glass = LightContext { transmits: true, ..surface };
    let medium = LightContext { normal: Vec3::ZERO, ..surface };
    for (ctx, shares) in
        [(surface, [0.5 / 1.8, 0.5 / 1.8, 4.0 / 9.0]), (glass, [0.5, 0.5, 0.0]), (medium, [0.5, 0.5, 0.0])]
    {
        let found = [0, 1, 2].map(|i| table.probability(&ctx, i));
        assert!((0..3).all(|i| (found[i] - shares[i]).abs() < 1e-6), "{found:?} {shares:?}");
    }
    let alone = LightTable::new(vec![environment(RADIANCE)], 0.0).unwrap();
    assert_eq!((alone.probability(&surface, 0), alone.probability(&glass, 0)), (1.0, 0.0));
    let two = LightTable::new(vec![sky, lamp, environment(RADIANCE)], 1.0);
    assert_eq!(two.err(), Some(LightTableError::SeveralEnvironments));
}

/// Same bits: the choice and the sample are a function of their arguments alone.
#[test]
fn a_table_is_deterministic() {
    let (a, b) = (LightTable::new(crowd(777, 3), 4.0).unwrap(), LightTable::new(crowd(777, 3), 4.0).unwrap());
    let mut rng = Rng::new(7);
    for Case { ctx, .. } in cases::without_surface() {
        let (select, u) = (rng.f64(), rng.f32x2());
        assert_eq!(format!("{:?}", a.sample(&ctx, select, u)), format!("{:?}", b.sample(&ctx, select, u)));
    }
}
