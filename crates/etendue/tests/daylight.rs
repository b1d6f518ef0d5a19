//! Sun and sky: brightness and colour as measured in nature, twilight, and the sun as a light among others.
#![allow(clippy::disallowed_methods)]

mod common;

use common::*;
use etendue::{
    bsdf::Density,
    light::{
        ImageEnvironment, Light, LightContext, RadianceMap, SunSky,
        atmosphere::{Atmosphere, Daylight, EFFICACY},
    },
    math::{DMat3, DVec3, Vec3, dvec3},
    scene::{Environment, SceneParts},
    spectrum::Spectrum,
};
use etendue_testkit::{
    Moments, Rng,
    chi2::ChiSquare,
    sidak,
    tiles::{Demands, Replicates, compare},
    ttest::t_test,
};
use std::{f64::consts::PI, sync::Arc};

fn daylight(turbidity: f64, elevation: f64) -> Daylight {
    Atmosphere { turbidity, ground: Spectrum::splat(0.2) }.daylight(elevation.to_radians())
}

/// Luminance, cd/m^2, or illuminance, lx.
fn luminance(colour: Spectrum) -> f64 {
    let [r, g, b] = colour.0.map(f64::from);
    EFFICACY * (0.2126 * r + 0.7152 * g + 0.0722 * b)
}

/// Chromaticity x, y in the CIE's diagram of 1931.
fn chromaticity(colour: Spectrum) -> [f64; 2] {
    let [r, g, b] = colour.0.map(f64::from);
    let x = 0.4124 * r + 0.3576 * g + 0.1805 * b;
    let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let z = 0.0193 * r + 0.1192 * g + 0.9505 * b;
    [x / (x + y + z), y / (x + y + z)]
}

/// Radiance at an elevation and an azimuth from the sun, degrees.
fn sky_at(map: &RadianceMap, elevation: f64, azimuth: f64) -> Spectrum {
    map.lookup((0.5 - azimuth / 360.0) as f32, (0.5 - elevation / 180.0) as f32)
}

/// Illuminance of the ground by the sky without the sun, lx.
fn from_sky(map: &RadianceMap) -> f64 {
    let mut sum = 0.0;
    for i in 0..180 {
        let height = 0.5 * (f64::from(i) + 0.5);
        let (sin, cos) = height.to_radians().sin_cos();
        for j in 0..72 {
            let area = cos * 0.5f64.to_radians() * 5f64.to_radians();
            sum += luminance(sky_at(map, height, 5.0 * f64::from(j))) * sin * area;
        }
    }
    sum
}

/// Outside of the atmosphere the sun gives 133 klx (solar constant 1361 W m^-2 at 98 lm/W). High in a clear sky 100 to 110 klx
/// are left on a plane that faces it, and the whole sky adds 10 to 25 klx (IES Lighting Handbook; Littlefair, "The luminous
/// efficacy of daylight", 1985: horizontal illuminance of a clear sky 8 + 15.5 sqrt(sin h) klx and less by half).
#[test]
fn a_high_sun_is_as_bright_as_in_nature() {
    for (turbidity, elevation, sun, sky) in [
        (2.0, 60.0, 98e3..112e3, 11e3..22e3),
        (2.5, 60.0, 92e3..107e3, 14e3..27e3),
        (2.5, 30.0, 68e3..90e3, 10e3..20e3),
        (3.0, 10.0, 15e3..45e3, 5e3..10e3),
    ] {
        let light = daylight(turbidity, elevation);
        let found = (luminance(light.sun), from_sky(&light.map));
        assert!(sun.contains(&found.0), "T {turbidity}, {elevation}: the sun gives {} lx", found.0);
        assert!(sky.contains(&found.1), "T {turbidity}, {elevation}: the sky gives {} lx", found.1);
    }
}

/// Clear blue skies have 2 to 6 kcd/m^2 at the zenith with the sun at 40 to 60 degrees (CIE 110-1994), and grow brighter
/// towards the horizon.
#[test]
fn the_sky_is_bright_as_in_nature() {
    for (turbidity, elevation, zenith) in [(2.0, 60.0, 3e3..6e3), (2.5, 40.0, 1.8e3..4e3), (3.0, 20.0, 1e3..3e3)] {
        let map = daylight(turbidity, elevation).map;
        let (above, low) = (luminance(sky_at(&map, 89.5, 0.0)), luminance(sky_at(&map, 5.0, 180.0)));
        assert!(zenith.contains(&above), "T {turbidity}, {elevation}: {above} cd/m^2 at the zenith");
        assert!(low > 1.5 * above, "T {turbidity}, {elevation}: {low} at the horizon, {above} at the zenith");
    }
}

/// Skylight is on the daylight locus at correlated colour temperatures from 9000 K to infinity (Judd, MacAdam and Wyszecki,
/// "Spectral Distribution of Typical Daylight as a Function of Correlated Color Temperature", 1964), x below 0.29; the sun
/// at 60 degrees is near 5500 K, x = 0.332, y = 0.347; at 3 degrees it is deep orange.
#[test]
fn colours_of_the_sky() {
    let high = daylight(2.0, 60.0);
    let [x, y] = chromaticity(high.sun);
    assert!((x - 0.336).abs() < 0.01 && (y - 0.348).abs() < 0.01, "sun at 60 degrees: {x}, {y}");
    let [x, y] = chromaticity(sky_at(&daylight(2.0, 40.0).map, 70.0, 180.0));
    assert!((0.23..0.29).contains(&x) && (0.23..0.30).contains(&y), "blue sky: {x}, {y}");
    let low = daylight(2.5, 3.0);
    let [x, y] = chromaticity(low.sun);
    assert!(x > 0.47 && y < 0.44 && y > 0.35, "sun at 3 degrees: {x}, {y}");
    assert!(luminance(low.sun) < 0.05 * luminance(high.sun));
    // Ozone keeps the zenith blue after sunset (Hulburt, "Explanation of the Brightness and Color of the Sky,
    // Particularly the Twilight Sky", 1953).
    let [x, _] = chromaticity(sky_at(&daylight(2.5, -4.0).map, 89.0, 0.0));
    assert!(x < 0.28, "zenith in twilight: {x}");
    // More haze, whiter.
    let haze = [2.0, 4.0, 8.0].map(|t| chromaticity(sky_at(&daylight(t, 40.0).map, 60.0, 180.0))[0]);
    assert!(haze[0] < haze[1] && haze[1] < haze[2], "{haze:?}");
}

/// Horizontal illuminance from sun and sky at sunset and in twilight: 400 to 1200 lx at 0 degrees, 2 to 8 lx at the end of civil
/// twilight, 0.004 to 0.05 lx at the end of nautical twilight (Explanatory Supplement to the Astronomical Almanac, 1992,
/// table 9.3-1: 732, 3.4 and 0.0083 lx). Then nothing.
#[test]
fn twilight_falls_to_nothing() {
    for (elevation, range) in [(0.0, 400.0..1300.0), (-6.0, 2.0..9.0), (-12.0, 0.004..0.05)] {
        let light = daylight(2.5, elevation);
        let found = from_sky(&light.map);
        assert!(range.contains(&found), "{elevation}: {found} lx");
        assert!(elevation >= 0.0 || light.sun.is_black());
    }
    for elevation in [-25.0, -60.0, -90.0] {
        let light = daylight(5.0, elevation);
        assert!(from_sky(&light.map) < 1e-4 && light.sun.is_black(), "{elevation}");
        assert_eq!(light.map.repaired(), 0);
    }
}

/// Every texel is a finite colour, and brightness falls with the sun, for every sun and haze.
#[test]
fn skies_are_fine_and_continuous() {
    let mut rng = Rng::new(1);
    for _ in 0..5 {
        let (turbidity, elevation) = (1.0 + 9.0 * rng.f64(), rng.range(-20.0, 90.0));
        let (a, b) = (daylight(turbidity, elevation), daylight(turbidity, elevation + 0.05));
        assert_eq!(a.map.repaired(), 0, "T {turbidity}, {elevation}");
        for (height, azimuth) in [(80.0, 20.0), (30.0, 180.0), (3.0, 90.0), (-30.0, 0.0)] {
            let [low, high] = [&a, &b].map(|light| luminance(sky_at(&light.map, height, azimuth)));
            assert!((low / high - 1.0).abs() < 0.1 || high < 1e-3, "T {turbidity}, {elevation}: {low} {high}");
        }
    }
    assert_eq!(daylight(3.0, 20.0).map, daylight(3.0, 20.0).map);
}

/// Below the horizon is the ground with what falls on it.
#[test]
fn the_ground_reflects_sun_and_sky() {
    let light = daylight(2.5, 50.0);
    let lit = luminance(light.sun) * 50f64.to_radians().sin() + from_sky(&light.map);
    let found = luminance(sky_at(&light.map, -40.0, 77.0));
    assert!((found / (0.2 * lit / PI) - 1.0).abs() < 0.01, "{found}, not {}", 0.2 * lit / PI);
}

const ANYWHERE: LightContext = LightContext { point: Vec3::ZERO, normal: Vec3::ZERO, transmits: false, time: 0.0 };

/// A small sky with a sun that stands `elevation` degrees high towards +z, of `radius` degrees.
fn sun_and_sky(elevation: f64, radius: f64, irradiance: f32) -> Light {
    let map = RadianceMap::new(16, 8, (0..128).map(|i| [0.2, 0.3, (i % 7) as f32 * 0.1]).collect()).unwrap();
    let sky = ImageEnvironment::new(Arc::new(map), DMat3::IDENTITY, Spectrum::ONE);
    let (sin, cos) = elevation.to_radians().sin_cos();
    let (sun, up) = (dvec3(0.0, sin, cos), DVec3::Y);
    Light::SunSky(Arc::new(SunSky::new(sky, sun, up, radius.to_radians(), Spectrum::splat(irradiance))))
}

/// In coordinates about the sun, for suns of the true size and much larger ones.
#[test]
fn chi_square_of_suns() {
    for (i, (elevation, radius)) in [(40.0, 0.2666), (3.0, 5.0), (-0.1, 0.2666), (70.0, 60.0)].into_iter().enumerate() {
        let light = sun_and_sky(elevation, radius, 20.0);
        let (sin, cos) = f64::to_radians(elevation).sin_cos();
        let axes = [DVec3::X, dvec3(0.0, cos, -sin), dvec3(0.0, sin, cos)];
        // Chord from the sun's middle over four times that of its rim (squared: equal areas), and turns about it.
        let scale = (16.0 * 4.0 * (0.5 * f64::to_radians(radius)).sin().powi(2)).min(4.0);
        let chart = |wi: Vec3| {
            let [x, y, z] = axes.map(|axis| axis.dot(wi.as_dvec3()));
            [((wi.as_dvec3() - axes[2]).length_squared() / scale).min(1.0), y.atan2(x) / (2.0 * PI), z]
        };
        let from_chart = |[squared, turns]: [f64; 2]| {
            let chord = squared * scale;
            let (s, c) = (2.0 * PI * turns).sin_cos();
            let radius = (chord * (1.0 - 0.25 * chord)).max(0.0).sqrt();
            ((axes[0] * c + axes[1] * s) * radius + axes[2] * (1.0 - 0.5 * chord)).as_vec3()
        };
        ChiSquare::new(100_000)
            .seed(i as u64)
            .mass_tolerance(4e-3)
            .stray_fraction(1e-3)
            .rectangle(
                [0.0, 1.0],
                [-0.5, 0.5],
                |rng| {
                    let sample = light.sample(&ANYWHERE, rng.f32x2())?;
                    let [squared, turns, _] = chart(sample.wi);
                    (squared < 1.0).then_some([squared, turns])
                },
                |at| PI * scale * f64::from(light.pdf(&ANYWHERE, from_chart(at), f32::INFINITY)),
            )
            .assert(0.01, 4, &format!("sun of {radius} degrees at {elevation}"));
    }
}

/// Samples are what rays along them find, and carry the irradiance of the sun that is above the horizon.
#[test]
fn samples_carry_the_sun() {
    let share = |elevation: f64, radius: f64| {
        let x = (elevation / radius).clamp(-1.0, 1.0);
        1.0 - (x.acos() - x * (1.0 - x * x).sqrt()) / PI
    };
    for (i, (elevation, radius)) in
        [(40.0, 0.2666), (0.1, 0.2666), (0.0, 3.0), (-1.0, 3.0), (-4.0, 3.0)].into_iter().enumerate()
    {
        let (lit, dark) = (sun_and_sky(elevation, radius, 50.0), sun_and_sky(elevation, radius, 0.0));
        let mut rng = Rng::new(i as u64);
        let mut estimate = |light: &Light| {
            (0..400_000)
                .map(|_| {
                    let sample = light.sample(&ANYWHERE, rng.f32x2()).expect("the sky shines");
                    assert_eq!(sample.radiance, light.environment_radiance(sample.wi));
                    let Density::SolidAngle(density) = sample.density else { panic!() };
                    assert_eq!(density, light.pdf(&ANYWHERE, sample.wi, f32::INFINITY));
                    f64::from(sample.radiance[0]) / f64::from(density)
                })
                .collect::<Moments>()
        };
        let sky = 4.0 * PI * f64::from(dark.radiance()[0]);
        for (name, light, expected) in [("sky", &dark, sky), ("both", &lit, 50.0 * share(elevation, radius) + sky)] {
            let found = estimate(light);
            if (found.mean() / expected - 1.0).abs() > 2e-3 {
                t_test(&found, expected).assert(sidak(0.01, 10), &format!("{name}, {elevation}, {radius}"));
            }
        }
        let stated = lit.power(1.0) / PI;
        let three = (0..3).map(|c| f64::from(lit.radiance()[c])).sum::<f64>() / 3.0 * 4.0 * PI;
        assert!((stated / three - 1.0).abs() < 1e-6);
    }
}

/// Below the horizon no ray meets the sun, whatever its size; beside it neither.
#[test]
fn the_sun_is_above_the_horizon() {
    let (lit, dark) = (sun_and_sky(0.5, 20.0, 1e4), sun_and_sky(0.5, 20.0, 0.0));
    let mut rng = Rng::new(4);
    let mut met = 0;
    for _ in 0..100_000 {
        let [x, y, z] = rng.direction();
        let wi = dvec3(x, y, z).as_vec3();
        let is_sun = lit.environment_radiance(wi) != dark.environment_radiance(wi);
        let angle = dvec3(0.0, 0.5f64.to_radians().sin(), 0.5f64.to_radians().cos()).dot(wi.as_dvec3()).acos();
        assert!(!is_sun || (wi.y > 0.0 && angle < 20.01f64.to_radians()), "{wi}");
        met += u32::from(is_sun);
    }
    assert!(met > 1000);
}

fn ball_on_a_floor(elevation: f64, sun_radius: f64) -> SceneParts {
    let mut parts = Parts::default();
    let white = parts.diffuse([0.6; 3]);
    parts.rectangle(dvec3(-5.0, 0.0, -5.0), dvec3(0.0, 0.0, 10.0), dvec3(10.0, 0.0, 0.0), white);
    parts.sphere(dvec3(0.0, 0.7, 0.0), 0.7, white);
    let (sin, cos) = elevation.to_radians().sin_cos();
    parts.0.environment = Some(Environment::Sky {
        sun: dvec3(0.6 * cos, sin, 0.8 * cos),
        up: DVec3::Y,
        atmosphere: Atmosphere { turbidity: 3.0, ground: Spectrum::splat(0.2) },
        strength: Spectrum([0.01, 0.01, 0.012]),
        sun_radius: sun_radius.to_radians(),
        sun_disk: true,
    });
    parts.0
}

/// With a sun large enough for BSDF samples to find it.
#[test]
fn solvers_agree_under_sun_and_sky() {
    let scene = Parts(ball_on_a_floor(25.0, 12.0)).build();
    let view = camera(dvec3(0.5, 3.0, 5.0), dvec3(0.0, 0.2, 0.0));
    let replicates = |integrator: usize, spp: u32| {
        let mut all = Replicates::new([24, 24], 3, 8);
        for replicate in 0..32 {
            let mut settings = statistics(SOLVERS[integrator], spp);
            settings.seed = 7000 * (integrator as u64 + 1) + replicate;
            settings.max_depth = Some(6);
            all.push(&interleaved(&picture(&scene, &view, [24, 24], &settings)));
        }
        all
    };
    let path = replicates(0, 48);
    let demands = Demands { level: sidak(0.01, 2), ..Demands::default() };
    for (other, spp) in [(1, 48), (2, 256)] {
        compare(&path, &replicates(other, spp)).assert(demands, &format!("path against {}", SOLVERS[other]));
    }
}
