//! Estimates of irradiance against closed forms.

use super::{
    cases::{self, Case, RADIANCE},
    double, samples,
};
use etendue::{
    light::{Light, LightContext, LightSample, SphereLight},
    math::{DMat3, DVec3, Vec3},
};
use etendue_testkit::{Moments, Rng, sidak, ttest::t_test};
use std::f64::consts::PI;

/// What the sample adds to the irradiance in the first channel, on one side of the normal.
pub fn gathered(sample: Option<LightSample>, normal: DVec3) -> f64 {
    let Some(sample) = sample else { return 0.0 };
    let density = sample.density.value();
    f64::from(sample.radiance[0]) * double(sample.wi).dot(normal).max(0.0) / f64::from(density)
}

/// Irradiance over radiance by Lambert's formula for polygons ("Photometria", 1760): half the sum of the angles under which
/// the edges are seen, each times the cosine between the receiver's normal and the normal of the edge's plane. Above the
/// horizon only.
fn polygon(corners: &[DVec3], point: DVec3, normal: DVec3) -> f64 {
    let mut above = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        let (a, b) = (a - point, corners[(i + 1) % corners.len()] - point);
        let (ha, hb) = (a.dot(normal), b.dot(normal));
        if ha >= 0.0 {
            above.push(a);
        }
        if (ha < 0.0) != (hb < 0.0) {
            above.push(a + (b - a) * (ha / (ha - hb)));
        }
    }
    let edges = (0..above.len()).map(|i| {
        let (a, b) = (above[i], above[(i + 1) % above.len()]);
        let cross = a.cross(b);
        let length = cross.length();
        if length == 0.0 { 0.0 } else { length.atan2(a.dot(b)) * cross.dot(normal) / length }
    });
    0.5 * edges.sum::<f64>().abs()
}

/// The outline under which an ellipsoid is seen from outside, as a polygon: a circle on the sphere that is mapped.
fn outline(sphere: &SphereLight, point: DVec3) -> Vec<DVec3> {
    let [x, y, z] = sphere.axes.map(double);
    let (map, center) = (DMat3::from_cols(x, y, z), double(sphere.center));
    let from = map.inverse() * (point - center);
    let axis = from.normalize();
    let (height, radius) = (1.0 / from.length(), (1.0 - 1.0 / from.length_squared()).sqrt());
    let x = axis.any_orthonormal_vector();
    let y = axis.cross(x);
    const SIDES: u32 = 4096;
    let corner = |i: u32| {
        let (sin, cos) = (2.0 * PI * f64::from(i) / f64::from(SIDES)).sin_cos();
        center + map * (axis * height + (x * cos + y * sin) * radius)
    };
    (0..SIDES).map(corner).collect()
}

/// Irradiance in the first channel on a plane with `normal`.
pub fn closed_form(light: &Light, point: Vec3, normal: DVec3) -> f64 {
    let radiance = f64::from(RADIANCE[0]);
    let at = double(point);
    match light {
        Light::Triangle(t) => {
            let [a, b, c] = t.vertices.map(double);
            let seen = t.two_sided || (b - a).cross(c - a).dot(at - a) > 0.0;
            if seen { radiance * polygon(&[a, b, c], at, normal) } else { 0.0 }
        }
        Light::Rectangle(r) => {
            let (a, u, v) = (double(r.corner), double(r.u), double(r.v));
            let seen = r.two_sided || u.cross(v).dot(at - a) > 0.0;
            if seen { radiance * polygon(&[a, a + u, a + u + v, a + v], at, normal) } else { 0.0 }
        }
        Light::Disk(d) => {
            let (center, normal_of) = (d.outline.center(), d.outline.normal());
            let seen = d.two_sided || normal_of.dot(at - center) > 0.0;
            let rim: Vec<DVec3> = d.outline.rim().collect();
            if seen { radiance * polygon(&rim, at, normal) } else { 0.0 }
        }
        Light::Sphere(s) => {
            let [x, y, z] = s.axes.map(double);
            let from = DMat3::from_cols(x, y, z).inverse() * (at - double(s.center));
            match (from.length() > 1.0, s.two_sided) {
                (true, _) => radiance * polygon(&outline(s, at), at, normal),
                (false, true) => radiance * PI,
                (false, false) => 0.0,
            }
        }
        Light::Point(p) => {
            let offset = double(p.position) - at;
            f64::from(p.intensity[0]) * offset.normalize().dot(normal).max(0.0) / offset.length_squared()
        }
        Light::Spot(s) => {
            let offset = double(s.position) - at;
            let (inner, outer) = (f64::from(s.cos_inner), f64::from(s.cos_outer));
            let cos = -offset.normalize().dot(double(s.axis));
            let t = if cos >= inner { 1.0 } else { ((cos - outer) / (inner - outer)).max(0.0) };
            let intensity = f64::from(s.intensity[0]) * t * t * (3.0 - 2.0 * t);
            intensity * offset.normalize().dot(normal).max(0.0) / offset.length_squared()
        }
        Light::Directional(d) => f64::from(d.irradiance[0]) * -double(d.direction).dot(normal).min(0.0),
        // The same from everywhere, in the cases that come here.
        Light::Environment(_) | Light::Image(_) => f64::from(light.radiance()[0]) * PI,
        Light::SunSky(_) => gathered_by_steps(light, normal),
    }
}

/// By the midpoint rule over the hemisphere, in equal areas.
fn gathered_by_steps(light: &Light, normal: DVec3) -> f64 {
    const SIDES: [u32; 2] = [1200, 300];
    let (x, cells) = (normal.any_orthonormal_vector(), f64::from(SIDES[0] * SIDES[1]));
    let y = normal.cross(x);
    let cell = |i: u32| {
        let cos = (f64::from(i / SIDES[0]) + 0.5) / f64::from(SIDES[1]);
        let (sin_turn, cos_turn) = (2.0 * PI * (f64::from(i % SIDES[0]) + 0.5) / f64::from(SIDES[0])).sin_cos();
        let wi = normal * cos + (x * cos_turn + y * sin_turn) * (1.0 - cos * cos).sqrt();
        f64::from(light.environment_radiance(wi.as_vec3())[0]) * cos * 2.0 * PI / cells
    };
    (0..SIDES[0] * SIDES[1]).map(cell).sum()
}

/// A t-test, but for differences within f32 rounding of `scale`, the irradiance of a receiver that faces the light:
/// those are no matter of chance.
pub fn assert_agrees(estimate: &Moments, reference: f64, scale: f64, tests: usize, what: &str) {
    if (estimate.mean() - reference).abs() > 1e-6 * scale {
        t_test(estimate, reference).assert(sidak(0.01, tests), what);
    }
}

#[test]
fn irradiance_of_every_light_from_everywhere() {
    assert_irradiances(&cases::all());
}

#[test]
fn irradiance_of_polygons_that_are_nearly_disks() {
    assert_irradiances(&cases::coarse_disks());
}

fn assert_irradiances(cases: &[Case]) {
    let tests = 2 * cases.len();
    for (i, Case { name, light, ctx }) in cases.iter().enumerate() {
        // A normal that sees all or most of the light, and one that it crosses the horizon of.
        let mut rng = Rng::new(i as u64);
        let seen = light.sample(ctx, [0.5, 0.5]).map_or(Vec3::Z, |sample| sample.wi);
        let tilted = (double(seen) + 0.8 * DVec3::from(rng.direction())).normalize();
        let across = double(seen).cross(DVec3::from(rng.direction())).normalize();
        for normal in [tilted, across] {
            let ctx = LightContext { normal: normal.as_vec3(), ..*ctx };
            let normal = double(ctx.normal);
            let n = samples(4_000, 200_000);
            let estimate: Moments = (0..n).map(|_| gathered(light.sample(&ctx, rng.f32x2()), normal)).collect();
            let facing = light.sample(&ctx, [0.5, 0.5]).map_or(0.0, |s| gathered(Some(s), double(s.wi)));
            assert_agrees(&estimate, closed_form(light, ctx.point, normal), facing, tests, name);
        }
    }
}

/// The estimators against textbook values, not against the general formulas above.
#[test]
fn textbook_values() {
    let radiance = f64::from(RADIANCE[0]);
    let estimate = |light: Light, ctx: &LightContext| {
        let mut rng = Rng::new(8);
        (0..samples(20_000, 1_000_000))
            .map(|_| gathered(light.sample(ctx, rng.f32x2()), double(ctx.normal)))
            .collect::<Moments>()
    };
    // A sphere straight above: E = pi L (R / d)^2.
    let ctx = LightContext { point: Vec3::ZERO, normal: Vec3::Z, transmits: false, time: 0.0 };
    for distance in [1.01f32, 3.0, 1e6] {
        let sphere = SphereLight::round(Vec3::new(0.0, 0.0, distance), 1.0, RADIANCE);
        let expected = PI * radiance / f64::from(distance).powi(2);
        assert_agrees(&estimate(Light::Sphere(sphere), &ctx), expected, expected, 6, "sphere above a plane");
        let general = closed_form(&Light::Sphere(sphere), ctx.point, double(ctx.normal));
        assert!((general / expected - 1.0).abs() < 1e-5, "{general} {expected}");
    }
    // A square of side 2 a at height h over a parallel plane: four corners a x a, E = 4 L / 2 * 2 (k / sqrt(1 + k^2))
    // atan(k / sqrt(1 + k^2)), k = a / h.
    for height in [0.05f32, 1.0, 40.0] {
        let square = etendue::light::RectangleLight {
            corner: Vec3::new(-1.0, -1.0, height),
            u: Vec3::new(0.0, 2.0, 0.0),
            v: Vec3::new(2.0, 0.0, 0.0),
            radiance: RADIANCE,
            two_sided: false,
        };
        let k = 1.0 / f64::from(height);
        let s = k / (1.0 + k * k).sqrt();
        let expected = 4.0 * radiance * s * s.atan();
        assert_agrees(&estimate(Light::Rectangle(square), &ctx), expected, expected, 6, "square above a plane");
    }
}

/// Where light from below counts too, an environment gives pi L on each side.
#[test]
fn both_sides_of_a_sheet() {
    let light = Light::Environment(etendue::light::ConstantEnvironment { radiance: RADIANCE });
    let ctx = LightContext { point: Vec3::ZERO, normal: Vec3::new(0.6, 0.0, 0.8), transmits: true, time: 0.0 };
    let mut rng = Rng::new(9);
    let estimate: Moments = (0..samples(50_000, 1_000_000))
        .map(|_| {
            let sample = light.sample(&ctx, rng.f32x2());
            gathered(sample, double(ctx.normal)) + gathered(sample, -double(ctx.normal))
        })
        .collect();
    let expected = 2.0 * PI * f64::from(RADIANCE[0]);
    assert_agrees(&estimate, expected, expected, 1, "environment on both sides");
}
