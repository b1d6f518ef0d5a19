//! Directions against densities, in coordinates on the light's own surface, where the density has no jumps: there it is
//! the density per solid angle times cos / d^2 times the area element.

use super::{
    cases::{self, Case, RADIANCE},
    double, samples,
};
use etendue::{
    bsdf::Density,
    light::{DiskLight, Light, LightContext, LightSample, SphereLight},
    math::{DMat3, DVec3, Vec3, dvec3},
};
use etendue_testkit::{Rng, chi2::ChiSquare};
use std::f64::consts::{PI, TAU};

/// The offset of targets that the module's text promises.
pub fn margin(case: &Case) -> f64 {
    let world = double(case.ctx.point);
    let (corners, extent) = match &case.light {
        Light::Sphere(s) => (vec![double(s.center)], s.axes.iter().map(|a| double(*a).length()).sum()),
        Light::Disk(d) => (vec![d.outline.center()], d.outline.radius()),
        light => {
            let [a, b, c] = corners(light).unwrap();
            (if matches!(light, Light::Triangle(_)) { vec![a, b, c] } else { vec![a, b, c, b + c - a] }, 0.0)
        }
    };
    let coordinate = corners.iter().map(|c| c.abs().max_element() + extent).fold(world.abs().max_element(), f64::max);
    let distance = corners.iter().map(|c| (*c - world).abs().max_element() + extent).fold(0.0, f64::max);
    (coordinate + distance) / 1_048_576.0
}

/// Point, unit normal towards the context, and area element at parameters.
type At = dyn Fn([f64; 2]) -> (DVec3, DVec3, f64);
/// Parameters of a sample.
type Locate = dyn Fn(&LightSample) -> [f64; 2];

/// A chart of a light's surface on a rectangle of parameters.
struct Chart {
    range: [[f64; 2]; 2],
    point: Box<At>,
    locate: Box<Locate>,
}

fn corners(light: &Light) -> Option<[DVec3; 3]> {
    match light {
        Light::Triangle(t) => Some(t.vertices.map(double)),
        Light::Rectangle(r) => {
            let corner = double(r.corner);
            Some([corner, corner + double(r.u), corner + double(r.v)])
        }
        Light::Disk(d) => Some(square(d)),
        _ => None,
    }
}

/// Corners of the square about a disk.
fn square(disk: &DiskLight) -> [DVec3; 3] {
    let (normal, radius) = (disk.outline.normal(), disk.outline.radius());
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    let corner = disk.outline.center() - (x + y) * radius;
    [corner, corner + x * (2.0 * radius), corner + y * (2.0 * radius)]
}

/// Coordinates of `p` along the edges from the first corner, projected onto their plane.
fn along_edges([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 2] {
    let (u, v, w) = (b - a, c - a, p - a);
    let (uu, uv, vv, wu, wv) = (u.dot(u), u.dot(v), v.dot(v), w.dot(u), w.dot(v));
    let det = uu * vv - uv * uv;
    [(vv * wu - uv * wv) / det, (uu * wv - uv * wu) / det]
}

fn flat_chart(light: &Light, ctx: &LightContext) -> Option<Chart> {
    let [a, b, c] = corners(light)?;
    let cross = (b - a).cross(c - a);
    let normal = cross.normalize() * (double(ctx.point) - a).dot(cross).signum();
    let (is_triangle, is_disk) = (matches!(light, Light::Triangle(_)), matches!(light, Light::Disk(_)));
    let point = move |[s, t]: [f64; 2]| {
        let (sin, cos) = (TAU * t).sin_cos();
        let (x, y, stretch) = match () {
            () if is_triangle => (s * (1.0 - t), s * t, s),
            // By the square of the distance from the middle, and turns.
            () if is_disk => (0.5 + 0.5 * s.sqrt() * cos, 0.5 + 0.5 * s.sqrt() * sin, 0.25 * PI),
            () => (s, t, 1.0),
        };
        (a + (b - a) * x + (c - a) * y, normal, cross.length() * stretch)
    };
    let origin = double(ctx.point);
    let locate = move |sample: &LightSample| {
        let (target, wi) = (double(sample.target.unwrap()), double(sample.wi));
        // Rounding hurts the direction to a far light, and the target of a near one.
        let is_far = target.distance(origin) > 100.0 * (b - a).length();
        let on_ray = origin + wi * ((a - origin).dot(cross) / wi.dot(cross));
        let [x, y] = along_edges([a, b, c], if is_far { target } else { on_ray });
        let (dx, dy) = (2.0 * x - 1.0, 2.0 * y - 1.0);
        let at = match () {
            () if is_triangle => [x + y, y / (x + y)],
            () if is_disk => [dx * dx + dy * dy, (dy.atan2(dx) / TAU).rem_euclid(1.0)],
            () => [x, y],
        };
        at.map(|p| if p.abs() < 2e-3 || (p - 1.0).abs() < 2e-3 { p.clamp(0.0, 1.0) } else { p })
    };
    Some(Chart { range: [[0.0, 1.0]; 2], point: Box::new(point), locate: Box::new(locate) })
}

fn map(sphere: &SphereLight) -> DMat3 {
    let [x, y, z] = sphere.axes.map(double);
    DMat3::from_cols(x, y, z)
}

/// Height over the centre along the axis towards the context, and azimuth, on the unit sphere that is mapped.
fn cap_chart(sphere: &SphereLight, ctx: &LightContext) -> Option<Chart> {
    let (map, center, world) = (map(sphere), double(sphere.center), double(ctx.point));
    let inverse = map.inverse();
    let from = inverse * (world - center);
    if from.length() <= 1.0 {
        return None;
    }
    let axis = from.normalize();
    let x = axis.any_orthonormal_vector();
    let y = axis.cross(x);
    let point = move |[z, turns]: [f64; 2]| {
        let (sin, cos) = (TAU * turns).sin_cos();
        let surface = axis * z + (x * cos + y * sin) * (1.0 - z * z).sqrt();
        let cofactor = inverse.transpose() * surface * map.determinant().abs();
        (center + map * surface, cofactor.normalize(), cofactor.length() * TAU)
    };
    let horizon = 1.0 / from.length();
    let locate = move |sample: &LightSample| {
        let direction = (inverse * double(sample.wi)).normalize();
        let along = from.dot(direction);
        let closest = from - direction * along;
        let surface = (closest - direction * (1.0 - closest.length_squared()).max(0.0).sqrt()).normalize();
        let turns = surface.dot(y).atan2(surface.dot(x)) / TAU;
        [surface.dot(axis).clamp(horizon, 1.0), turns.rem_euclid(1.0)]
    };
    Some(Chart { range: [[horizon, 1.0], [0.0, 1.0]], point: Box::new(point), locate: Box::new(locate) })
}

fn chart(case: &Case) -> Option<Chart> {
    match &case.light {
        Light::Sphere(sphere) => cap_chart(sphere, &case.ctx),
        light => flat_chart(light, &case.ctx),
    }
}

/// Can the context see an emitting side, from farther than the margin?
fn is_visible(case: &Case) -> bool {
    let world = double(case.ctx.point);
    match &case.light {
        Light::Sphere(sphere) => {
            let from = map(sphere).inverse() * (world - double(sphere.center));
            sphere.two_sided || from.length() > 1.0
        }
        light => {
            let Some([a, b, c]) = corners(light) else { return true };
            let height = (b - a).cross(c - a).normalize().dot(world - a);
            if height.abs() <= margin(case) {
                return false;
            }
            match light {
                Light::Triangle(t) => t.two_sided || height > 0.0,
                Light::Rectangle(r) => r.two_sided || height > 0.0,
                Light::Disk(d) => d.two_sided || height > 0.0,
                _ => true,
            }
        }
    }
}

fn solid_angle_density(sample: &LightSample) -> f64 {
    match sample.density {
        Density::SolidAngle(density) => density.into(),
        _ => panic!("a density per solid angle was expected"),
    }
}

#[test]
fn chi_square_of_every_light_from_everywhere() {
    let cases: Vec<Case> = cases::with_surface().into_iter().filter(is_visible).collect();
    let tests = cases.len();
    for (i, case) in cases.iter().enumerate() {
        let ctx = &case.ctx;
        // At a far sphere's limb rounding of `wi` makes some directions miss it, where the density is zero.
        let test = ChiSquare::new(samples(12_000, 400_000)).cells(100).seed(i as u64).stray_fraction(2e-3);
        // Densities of disks jump where pairs begin to be seen.
        let test = if matches!(case.light, Light::Disk(_)) { test.pieces(4) } else { test };
        let outcome = match chart(case) {
            Some(chart) => test.rectangle(
                chart.range[0],
                chart.range[1],
                |rng| {
                    let u = rng.f32x2();
                    case.light.sample(ctx, u).map(|sample| (chart.locate)(&sample))
                },
                |at| {
                    let (point, normal, area) = (chart.point)(at);
                    let offset = point - double(ctx.point);
                    let distance = offset.length();
                    let wi = offset / distance;
                    let pdf = f64::from(case.light.pdf(ctx, wi.as_vec3(), distance as f32));
                    pdf * (-normal.dot(wi)).max(0.0) / (distance * distance) * area
                },
            ),
            None => around(case, &test),
        };
        if let Err(report) = outcome.check(0.01, tests) {
            panic!("{}:\n{report}", case.name);
        }
    }
}

#[test]
fn chi_square_of_environments() {
    let cases = cases::without_surface();
    let environments = cases.iter().filter(|case| case.light.is_environment());
    for (i, case) in environments.enumerate() {
        let test = ChiSquare::new(samples(40_000, 1_000_000)).seed(i as u64);
        around(case, &test).assert(0.01, 36, &case.name);
    }
}

/// Directions over the whole sphere.
fn around(case: &Case, test: &ChiSquare) -> etendue_testkit::chi2::Outcome {
    let array = |v: Vec3| double(v).to_array();
    test.sphere(
        |rng| case.light.sample(&case.ctx, rng.f32x2()).map(|sample| array(sample.wi)),
        |[x, y, z]| f64::from(case.light.pdf(&case.ctx, dvec3(x, y, z).as_vec3(), 1.0)),
    )
}

#[test]
fn density_of_a_sample_is_the_density_of_its_direction() {
    for case in cases::all() {
        let mut rng = Rng::new(3);
        for _ in 0..samples(300, 20_000) {
            let Some(sample) = case.light.sample(&case.ctx, rng.f32x2()) else { continue };
            if case.light.is_delta() {
                assert_eq!(sample.density, Density::Discrete(1.0));
                assert_eq!(case.light.pdf(&case.ctx, sample.wi, 1.0), 0.0);
                continue;
            }
            let distance = sample.target.map_or(f32::INFINITY, |target| target.distance(case.ctx.point));
            let pdf = f64::from(case.light.pdf(&case.ctx, sample.wi, distance));
            let density = solid_angle_density(&sample);
            assert!((pdf / density - 1.0).abs() < 1e-5, "{}: {density} but {pdf}", case.name);
        }
    }
}

#[test]
fn samples_exist_where_light_is_seen_and_only_there() {
    for case in cases::with_surface() {
        let mut rng = Rng::new(4);
        let drawn = (0..100).filter(|_| case.light.sample(&case.ctx, rng.f32x2()).is_some()).count();
        let expected = if is_visible(&case) { 100 } else { 0 };
        assert_eq!(drawn, expected, "{}", case.name);
        if expected == 0 {
            let to_light = Vec3::new(0.6, 0.0, 0.8);
            assert_eq!(case.light.pdf(&case.ctx, to_light, 1.0), 0.0, "{}", case.name);
        }
    }
}

/// The target is on the light but for the promised offset, off it on the context's side, and where `wi` points; the
/// extreme numbers are among the samples.
#[test]
fn targets_are_lifted_off_the_light() {
    const LAST: f32 = 1.0 - f32::EPSILON / 2.0;
    for case in cases::with_surface().into_iter().filter(is_visible) {
        let mut rng = Rng::new(5);
        let extremes = [[0.0, 0.0], [0.0, LAST], [LAST, 0.0], [LAST, LAST], [0.5, LAST], [LAST, 0.5]];
        let inner = (0..samples(200, 20_000)).map(|_| rng.f32x2());
        for u in extremes.into_iter().chain(inner) {
            match case.light.sample(&case.ctx, u) {
                Some(sample) => check_target(&case, &sample),
                // Between the polygon and the circle about it.
                None => assert!(matches!(case.light, Light::Disk(_)), "{}: nothing at {u:?}", case.name),
            }
        }
    }
}

fn check_target(case: &Case, sample: &LightSample) {
    let name = &case.name;
    let (origin, target) = (double(case.ctx.point), double(sample.target.unwrap()));
    let (wi, to_target) = (double(sample.wi), target - origin);
    assert!((wi.length() - 1.0).abs() < 1e-6, "{name}");
    assert_eq!(sample.radiance, RADIANCE, "{name}");
    let coordinate = origin.abs().max_element().max(target.abs().max_element());
    let margin = margin(case);
    let lifts = 0.8 * margin..1.2 * margin;
    let miss = to_target.cross(wi).length();
    assert!(miss < 1.2 * margin, "{name}: target is {miss} off the ray");
    match &case.light {
        Light::Sphere(sphere) => {
            let (map, center) = (map(sphere), double(sphere.center));
            let inverse = map.inverse();
            let (from, surface) = (inverse * (origin - center), inverse * (target - center));
            let gradient = (inverse.transpose() * surface).length() / surface.length();
            let lift = (surface.length() - 1.0) / gradient * (from.length() - 1.0).signum();
            assert!(lifts.contains(&lift), "{name}: lift {lift}, not {margin}");
            // From outside the whole segment stays outside; inside, convexity is enough.
            let along = surface - from;
            let closest = from + along * (-from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
            assert!(from.length() < 1.0 || closest.length() > 1.0, "{name}: the segment meets the sphere");
        }
        light => {
            let [a, b, c] = corners(light).unwrap();
            let normal = (b - a).cross(c - a).normalize();
            let (height, lift) = (normal.dot(origin - a), normal.dot(target - a));
            assert!(lifts.contains(&(lift * height.signum())), "{name}: lift {lift}, not {margin}");
            let [x, y] = along_edges([a, b, c], target);
            // Rounding moves a target by some 1e-7 of its coordinates, over the width of the light.
            let slack = 1e-6 * coordinate * (b - a).length().max((c - a).length()) / (b - a).cross(c - a).length();
            let inside = x > -slack && y > -slack && x.max(y) < 1.0 + slack;
            let triangle = matches!(light, Light::Triangle(_));
            let disk = matches!(light, Light::Disk(_));
            let from_middle = (2.0 * x - 1.0).hypot(2.0 * y - 1.0);
            let within = (!triangle || x + y < 1.0 + slack) && (!disk || from_middle < 1.0 + slack);
            assert!(inside && within, "{name}: ({x}, {y}) is not on the light");
        }
    }
}

/// A ray that meets the far side of a sphere from outside went through a near side that light sampling stops at.
#[test]
fn the_far_side_of_a_sphere_has_no_density() {
    let sphere = SphereLight { two_sided: true, ..SphereLight::round(Vec3::ZERO, 0.5, RADIANCE) };
    let ctx = LightContext { point: Vec3::new(0.0, 0.0, 2.0), normal: Vec3::ZERO, transmits: false, time: 0.0 };
    let light = Light::Sphere(sphere);
    assert!(light.pdf(&ctx, Vec3::NEG_Z, 1.5) > 0.0);
    assert_eq!(light.pdf(&ctx, Vec3::NEG_Z, 2.5), 0.0);
}
