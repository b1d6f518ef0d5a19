//! Skies from images: density and radiance of directions, orientation, ugly texels.

use super::{cases::RADIANCE, double, samples};
use etendue::{
    light::{ImageEnvironment, Light, LightContext, RadianceMap, RadianceMapError},
    math::{DMat3, DVec3, Vec3, dvec3, vec3},
    spectrum::Spectrum,
};
use etendue_testkit::{Moments, Rng, chi2::ChiSquare, sidak, ttest::t_test};
use std::{f64::consts::PI, sync::Arc};

const ANYWHERE: LightContext = LightContext { point: Vec3::ZERO, normal: Vec3::ZERO, transmits: false, time: 0.0 };

fn map(width: u32, height: u32, mut texel: impl FnMut(u32, u32) -> [f32; 3]) -> Arc<RadianceMap> {
    let at = |i: u32| (i % width, i / width);
    let texels = (0..width * height).map(|i| texel(at(i).0, at(i).1)).collect();
    Arc::new(RadianceMap::new(width, height, texels).unwrap())
}

/// Maps of several sizes with bright, dark and black parts.
fn maps() -> Vec<(&'static str, Arc<RadianceMap>)> {
    let mut rng = Rng::new(17);
    let sun = |x: u32, y: u32| if (x, y) == (50, 9) { [3e4, 2e4, 1e4] } else { [0.2, 0.4, 0.8] };
    let noise: Vec<f32> = (0..24 * 12).map(|_| (rng.f32() * 1.3 - 0.3).max(0.0).powi(3)).collect();
    let gradient = RadianceMap::gradient(RADIANCE, Spectrum::ONE, Spectrum::BLACK).unwrap();
    vec![
        ("one texel", map(1, 1, |_, _| [1.0, 2.0, 3.0])),
        ("noise", map(24, 12, |x, y| [noise[(y * 24 + x) as usize]; 3])),
        ("odd", map(7, 5, |x, y| [x as f32, y as f32, (x * y % 3) as f32])),
        ("sun", map(96, 48, sun)),
        ("lonely corner", map(64, 32, |x, y| if (x, y) == (0, 0) { [0.0, 0.0, 1.0] } else { [0.0; 3] })),
        ("many texels", map(2600, 1100, |x, y| [(x / 100 % 3 * (y / 90 % 2)) as f32, 0.1, 0.0])),
        ("gradient", Arc::new(gradient)),
    ]
}

fn turned() -> DMat3 {
    DMat3::from_axis_angle(dvec3(0.3, -0.7, 0.6).normalize(), 2.1)
}

fn skies() -> Vec<(&'static str, Light)> {
    let sky = |map| Light::Image(Arc::new(ImageEnvironment::new(map, turned(), Spectrum([1.0, 0.5, 2.0]))));
    maps().into_iter().map(|(name, map)| (name, sky(map))).collect()
}

/// Longitude from the centre column to the left, in turns, and height of a direction of a turned sky: equal areas.
fn chart(wi: Vec3) -> [f64; 2] {
    let local = turned().transpose() * double(wi);
    [local.x.atan2(local.z) / (2.0 * PI), local.y.clamp(-1.0, 1.0)]
}

fn from_chart([turns, height]: [f64; 2]) -> Vec3 {
    let (sin, cos) = (2.0 * PI * turns).sin_cos();
    let radius = (1.0 - height * height).max(0.0).sqrt();
    (turned() * dvec3(radius * sin, height, radius * cos)).as_vec3()
}

#[test]
fn chi_square_of_skies() {
    for (i, (name, sky)) in skies().into_iter().enumerate() {
        ChiSquare::new(samples(60_000, 2_000_000))
            .seed(i as u64)
            .mass_tolerance(2e-3)
            .stray_fraction(2e-4)
            .rectangle(
                [-0.5, 0.5],
                [-1.0, 1.0],
                |rng| sky.sample(&ANYWHERE, rng.f32x2()).map(|sample| chart(sample.wi)),
                |at| 2.0 * PI * f64::from(sky.pdf(&ANYWHERE, from_chart(at), f32::INFINITY)),
            )
            .assert(0.01, 7, name);
    }
}

/// Where a lookup is not black, light sampling can find it; also in the blur of the lookup around a lonely texel, across
/// the seam, and at the poles.
#[test]
fn density_is_above_0_wherever_there_is_light() {
    for (name, sky) in skies() {
        let mut rng = Rng::new(2);
        let (mut lit, mut dark) = (0, 0);
        for i in 0..samples(60_000, 2_000_000) {
            let [x, y, z] = rng.direction();
            // Every other direction near the lonely corner: the pole, and the seam below it.
            let corner = [rng.range(-0.55, 0.55), 1.0 - rng.f64() * 0.012];
            let wi = if i % 2 == 0 { dvec3(x, y, z).as_vec3() } else { from_chart(corner) };
            let (radiance, pdf) = (sky.environment_radiance(wi), sky.pdf(&ANYWHERE, wi, f32::INFINITY));
            assert!(radiance.is_black() || pdf > 0.0, "{name}: {radiance:?} at {:?}, density 0", chart(wi));
            lit += u32::from(!radiance.is_black());
            dark += u32::from(pdf == 0.0);
        }
        assert!(lit > 100, "{name}: {lit} lit");
        assert!(name != "lonely corner" || dark > 1000, "{name}: black parts are sampled");
    }
}

/// What a sample says is what a ray along it finds.
#[test]
fn samples_are_what_rays_find() {
    for (name, sky) in skies() {
        let mut rng = Rng::new(3);
        for _ in 0..2000 {
            let sample = sky.sample(&ANYWHERE, rng.f32x2()).expect("the sky shines");
            assert_eq!(sample.radiance, sky.environment_radiance(sample.wi), "{name}");
            let etendue::bsdf::Density::SolidAngle(density) = sample.density else { panic!("{name}") };
            assert_eq!(density, sky.pdf(&ANYWHERE, sample.wi, f32::INFINITY), "{name}");
        }
    }
}

/// The sphere's mean of looked-up radiance, by the midpoint rule in longitude and polar angle.
fn mean_by_lookups(sky: &Light) -> f64 {
    const SIDES: [u32; 2] = [1000, 1300];
    let mut sum = 0.0;
    for i in 0..SIDES[1] {
        let polar = PI * (f64::from(i) + 0.5) / f64::from(SIDES[1]);
        let area = 0.5 * PI / f64::from(SIDES[1]) * polar.sin() / f64::from(SIDES[0]);
        for j in 0..SIDES[0] {
            let wi = from_chart([(f64::from(j) + 0.5) / f64::from(SIDES[0]) - 0.5, polar.cos()]);
            sum += area * f64::from(sky.environment_radiance(wi).mean());
        }
    }
    sum
}

#[test]
fn samples_carry_the_energy_of_the_map() {
    for (i, (name, sky)) in skies().into_iter().enumerate() {
        let mut rng = Rng::new(i as u64);
        let estimate: Moments = (0..samples(100_000, 2_000_000))
            .map(|_| {
                let sample = sky.sample(&ANYWHERE, rng.f32x2()).expect("the sky shines");
                let etendue::bsdf::Density::SolidAngle(density) = sample.density else { panic!("{name}") };
                f64::from(sample.radiance.mean()) / f64::from(density)
            })
            .collect();
        let mean = mean_by_lookups(&sky);
        let stated = sky.power(1.0) / (4.0 * PI * PI);
        // Weights take the lookup's hat over a cell, not over its solid angle: at the pole that is a difference.
        let tolerance = if name == "lonely corner" { 0.2 } else { 5e-3 };
        assert!((stated / mean - 1.0).abs() < tolerance, "{name}: mean radiance {stated} but {mean} looked up");
        let expected = 4.0 * PI * mean;
        if (estimate.mean() / expected - 1.0).abs() > 2e-3 {
            t_test(&estimate, expected).assert(sidak(0.01, 7), name);
        }
        assert!(estimate.standard_error() < 0.01 * expected, "{name}: the test is blunt");
    }
}

/// A floor below a gradient: E = 2 pi (h / 2 + (t - h) / 3), since radiance is h + (t - h) cos(theta).
#[test]
fn irradiance_below_a_gradient() {
    let (top, horizon, bottom) = (4.0, 1.0, 9.0);
    let map = RadianceMap::gradient(Spectrum::splat(top), Spectrum::splat(horizon), Spectrum::splat(bottom)).unwrap();
    let sky = Light::Image(Arc::new(ImageEnvironment::new(Arc::new(map), DMat3::IDENTITY, Spectrum::ONE)));
    for (normal, far) in [(Vec3::Y, top), (Vec3::NEG_Y, bottom)] {
        let mut rng = Rng::new(5);
        let estimate: Moments = (0..samples(200_000, 3_000_000))
            .map(|_| super::irradiance::gathered(sky.sample(&ANYWHERE, rng.f32x2()), double(normal)))
            .collect();
        let (h, t) = (f64::from(horizon), f64::from(far));
        let expected = 2.0 * PI * (h / 2.0 + (t - h) / 3.0);
        t_test(&estimate, expected).assert(sidak(0.01, 2), "floor below a gradient");
        assert!(estimate.standard_error() < 0.02 * expected);
    }
}

/// The centre column looks along +z, +x is a quarter to the left, the first row is up.
#[test]
fn orientation_of_a_map() {
    let colour = |x: u32, y: u32| [x as f32, y as f32, 0.0];
    let sky = ImageEnvironment::new(map(400, 200, colour), DMat3::IDENTITY, Spectrum::ONE);
    let at = |direction: DVec3| sky.radiance_from(direction.normalize().as_vec3());
    for (direction, x, y) in [
        (dvec3(0.0, 0.0, 1.0), 199.5, 99.5),
        (dvec3(1.0, 0.0, 0.0), 99.5, 99.5),
        (dvec3(-1.0, 0.0, 0.0), 299.5, 99.5),
        (dvec3(0.0, 1.0, 1e-9), 199.5, 0.0),
        (dvec3(0.0, -1.0, 1e-9), 199.5, 199.0),
        (dvec3(0.0, 1.0, 1.0), 199.5, 49.5),
    ] {
        let found = at(direction);
        assert!((found[0] - x).abs() < 0.02 && (found[1] - y).abs() < 0.02, "{direction}: {found:?}");
    }
    // Seen from inside, up above, what is right of the centre is right in the picture.
    let (forward, up) = (dvec3(0.0, 0.0, 1.0), dvec3(0.0, 1.0, 0.0));
    assert!(at(forward + 0.1 * forward.cross(up))[0] > 199.5);
    // Turned by a quarter about up, counter-clockwise seen from above, the centre goes to +x.
    let turn = DMat3::from_rotation_y(0.5 * PI);
    let turned = ImageEnvironment::new(map(400, 200, colour), turn, Spectrum::ONE);
    assert!((turned.radiance_from(Vec3::X)[0] - 199.5).abs() < 0.02);
}

/// The seam has no edge.
#[test]
fn lookups_wrap_in_longitude_and_end_at_the_poles() {
    let map = map(16, 8, |x, y| [x as f32, y as f32, 1.0]);
    let (left, right) = (map.lookup(0.0, 0.5), map.lookup(1.0, 0.5));
    assert_eq!((left, left[0]), (right, 7.5));
    assert_eq!((map.lookup(0.5, 0.0)[1], map.lookup(0.5, 1.0)[1]), (0.0, 7.0));
    for wild in [f32::NAN, f32::INFINITY, -1e30, 1e30] {
        let _ = (map.lookup(wild, 0.5), map.lookup(0.5, wild));
    }
}

#[test]
fn ugly_texels_are_repaired_and_counted() {
    let texels = vec![[f32::NAN, 1.0, -2.0], [f32::INFINITY, 0.5, 0.25], [f32::MAX, 0.0, 0.0], [1.0, -0.0, 2.0]];
    let map = RadianceMap::new(4, 1, texels).unwrap();
    assert_eq!(map.repaired(), 3);
    assert_eq!(map.lookup(0.125, 0.5), Spectrum([0.0, 1.0, 0.0]));
    assert_eq!(map.lookup(0.375, 0.5), Spectrum([65504.0, 0.5, 0.25]));
    assert_eq!(RadianceMap::new(0, 3, vec![]).err(), Some(RadianceMapError::Size(0, 3)));
    assert_eq!(RadianceMap::new(u32::MAX, u32::MAX, vec![]).err(), Some(RadianceMapError::Size(u32::MAX, u32::MAX)));
    assert_eq!(RadianceMap::new(2, 2, vec![[0.0; 3]]).err(), Some(RadianceMapError::Count { expected: 4, found: 1 }));
    // A black map lights nothing.
    let black = RadianceMap::new(2, 2, vec![[0.0; 3]; 4]).unwrap();
    let sky = Light::Image(Arc::new(ImageEnvironment::new(Arc::new(black), DMat3::IDENTITY, Spectrum::ONE)));
    assert!(sky.sample(&ANYWHERE, [0.5; 2]).is_none() && sky.power(1.0) == 0.0);
    assert_eq!(sky.pdf(&ANYWHERE, vec3(0.0, 1.0, 0.0), f32::INFINITY), 0.0);
}
