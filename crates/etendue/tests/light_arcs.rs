//! Lights in arcs of circles: against rays, and the density of what is sampled.

#![allow(clippy::disallowed_methods)]

use etendue::{
    bsdf::{BrushedMetal, Bsdf, Density, GrooveForm},
    light::{
        DiskLight, Light, LightCircle, LightTable, PointLightSource, RectangleLight, RoundOutline, SphereLight,
        TriangleLight,
    },
    math::{DVec3, Frame, Vec3, vec3},
    spectrum::Spectrum,
};
use etendue_testkit::{Rng, chi2::ChiSquare, integrate_1d};
use std::{f64::consts::PI, sync::Arc};

fn vector(rng: &mut Rng, size: f64) -> Vec3 {
    let mut x = || (rng.range(-1.0, 1.0) * size) as f32;
    vec3(x(), x(), x())
}

fn unit(rng: &mut Rng) -> Vec3 {
    DVec3::from_array(rng.direction()).as_vec3().normalize()
}

/// The circle that brushed metal at `point` sees `wo` by, grooves across x.
fn circle(point: Vec3, normal: Vec3, x: Vec3, wo: Vec3, exponent: f32) -> Option<LightCircle> {
    let tangent = (x - normal * normal.dot(x)).normalize();
    let frame = Frame::from_tangent(normal, tangent);
    let metal = Bsdf::BrushedMetal(BrushedMetal::new(Spectrum::ONE, exponent, GrooveForm::Reciprocal));
    Some(LightCircle::new(point, &frame, &metal.circle(frame.to_local(wo))?))
}

fn any_circle(rng: &mut Rng, exponent: f32) -> LightCircle {
    loop {
        let (point, normal) = (vector(rng, 1.0), unit(rng));
        let (x, wo) = (unit(rng), unit(rng));
        if normal.dot(wo).abs() > 0.01
            && normal.dot(x).abs() < 0.99
            && let Some(circle) = circle(point, normal, x, wo, exponent)
        {
            return circle;
        }
    }
}

/// Of so many corners that it is the circle within a millionth.
fn disk(center: Vec3, normal: Vec3, radius: f64, radiance: Spectrum, two_sided: bool) -> Light {
    let x = normal.as_dvec3().any_orthonormal_vector();
    let y = normal.as_dvec3().cross(x);
    let corner = |i: u32| {
        let (sin, cos) = (2.0 * PI * f64::from(i) / 2000.0).sin_cos();
        center.as_dvec3() + (x * cos + y * sin) * radius
    };
    let outline = RoundOutline::new(&(0..2000).map(corner).collect::<Vec<_>>()).expect("is round");
    Light::Disk(Arc::new(DiskLight { outline, radiance, two_sided }))
}

/// A light of some kind within about 2 m of the origin.
fn any_light(rng: &mut Rng) -> Light {
    let radiance = Spectrum::splat(rng.range(0.5, 4.0) as f32);
    let two_sided = rng.f64() < 0.5;
    let size = [0.05, 1.0, 5.0][rng.u32() as usize % 3];
    let at = vector(rng, 2.0);
    match rng.u32() % 5 {
        4 => disk(at, unit(rng), 0.5 * size, radiance, two_sided),
        0 => {
            let vertices = [at, at + vector(rng, size), at + vector(rng, size)];
            Light::Triangle(TriangleLight { vertices, radiance, two_sided })
        }
        1 => {
            let (u, v) = (vector(rng, size), vector(rng, size));
            Light::Rectangle(RectangleLight { corner: at, u, v, radiance, two_sided })
        }
        2 => {
            let u = vector(rng, size);
            let v = u.cross(unit(rng));
            Light::Rectangle(RectangleLight { corner: at, u, v, radiance, two_sided })
        }
        _ => Light::Sphere(SphereLight { two_sided, ..SphereLight::round(at, 0.5 * size as f32, radiance) }),
    }
}

/// Distance at which a ray from `point` meets the light on an emitting side, by other means than the lights' own.
fn meets(light: &Light, point: Vec3, direction: DVec3) -> Option<f64> {
    let origin = point.as_dvec3();
    let flat = |corner: Vec3, u: DVec3, v: DVec3, two_sided: bool, within: fn(f64, f64) -> bool| {
        let (normal, from) = (u.cross(v), corner.as_dvec3() - origin);
        let t = from.dot(normal) / direction.dot(normal);
        let q = direction * t - from;
        let square = normal.length_squared();
        let (a, b) = (q.cross(v).dot(normal) / square, u.cross(q).dot(normal) / square);
        (t > 0.0 && within(a, b) && (two_sided || direction.dot(normal) < 0.0)).then_some(t)
    };
    match light {
        Light::Triangle(TriangleLight { vertices: [a, b, c], two_sided, .. }) => {
            let edge = |p: &Vec3| p.as_dvec3() - a.as_dvec3();
            flat(*a, edge(b), edge(c), *two_sided, |a, b| a >= 0.0 && b >= 0.0 && a + b <= 1.0)
        }
        Light::Rectangle(r) => flat(r.corner, r.u.as_dvec3(), r.v.as_dvec3(), r.two_sided, |a, b| {
            (0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b)
        }),
        Light::Disk(d) => {
            let (normal, from) = (d.outline.normal(), d.outline.center() - origin);
            let t = from.dot(normal) / direction.dot(normal);
            let within = d.outline.contains(direction * t - from);
            (t > 0.0 && within && (d.two_sided || direction.dot(normal) < 0.0)).then_some(t)
        }
        Light::Sphere(s) => {
            let (center, radius) = (s.center.as_dvec3() - origin, f64::from(s.axes[0].length()));
            let along = center.dot(direction);
            let under = radius * radius - (center - direction * along).length_squared();
            let inside = center.length() < radius;
            if under < 0.0 || (inside && !s.two_sided) {
                return None;
            }
            let t = if inside { along + under.sqrt() } else { along - under.sqrt() };
            (t > 0.0).then_some(t)
        }
        _ => None,
    }
}

/// How far the point is from the plane or surface of a light, relative to what the offset of targets needs.
fn is_close(light: &Light, point: Vec3) -> bool {
    let height = match light {
        Light::Triangle(t) => {
            let [a, b, c] = t.vertices;
            (point - a).dot((b - a).cross(c - a).normalize())
        }
        Light::Rectangle(r) => (point - r.corner).dot(r.u.cross(r.v).normalize()),
        Light::Disk(d) => (point.as_dvec3() - d.outline.center()).dot(d.outline.normal()) as f32,
        Light::Sphere(s) => (point - s.center).length() - s.axes[0].length(),
        _ => 1.0,
    };
    height.abs() <= 1e-3 || height.is_nan()
}

#[test]
fn arcs_are_where_rays_meet_the_light() {
    let mut rng = Rng::new(1);
    let (mut seen, mut several, mut most) = (0, 0, 0);
    for _ in 0..20_000 {
        let (circle, light) = (any_circle(&mut rng, 20.0), any_light(&mut rng));
        if is_close(&light, circle.point) {
            continue;
        }
        let arcs = light.arcs(&circle);
        let count = arcs.iter().count();
        (seen, several, most) = (seen + usize::from(count > 0), several + usize::from(count > 1), most.max(count));
        for pair in arcs.iter().zip(arcs.iter().skip(1)) {
            assert!(pair.0[1] < pair.1[0], "{arcs:?}");
        }
        assert!(arcs.iter().all(|[from, to]| 0.0 <= *from && from < to && *to <= PI));
        for i in 0..60 {
            let phi = PI * (f64::from(i) + rng.f64()) / 60.0;
            if arcs.iter().flatten().any(|end| (phi - end).abs() < 1e-5) {
                continue;
            }
            let hit = meets(&light, circle.point, circle.direction(phi));
            assert_eq!(arcs.contains(phi), hit.is_some(), "{light:?} {circle:?} {phi} {arcs:?}");
        }
    }
    assert!(seen > 2000 && several > 20 && most >= 2, "{seen} {several} {most}");
}

/// A table with lights of all kinds, some of which a circle never meets.
fn table(rng: &mut Rng, count: usize) -> LightTable {
    let mut lights: Vec<Light> = (0..count).map(|_| any_light(rng)).collect();
    lights.push(Light::Point(PointLightSource { position: Vec3::ONE, intensity: Spectrum::ONE }));
    LightTable::new(lights, 3.0).expect("a valid table")
}

/// Density of an angle, over all lights in that direction.
fn density(table: &LightTable, circle: &LightCircle, phi: f64) -> f64 {
    let direction = circle.direction(phi);
    let of_light = |(i, light): (usize, &Light)| {
        let Some(distance) = meets(light, circle.point, direction) else { return 0.0 };
        f64::from(table.pdf_circle(circle, i as u32, direction.as_vec3(), distance as f32))
    };
    table.lights().iter().enumerate().map(of_light).sum()
}

/// All ends of arcs, between which the density is smooth.
fn pieces(table: &LightTable, circle: &LightCircle) -> Vec<[f64; 2]> {
    let mut ends: Vec<f64> = table
        .lights()
        .iter()
        .flat_map(|light| light.arcs(circle).iter().flatten().copied().collect::<Vec<_>>())
        .collect();
    ends.sort_by(f64::total_cmp);
    ends.windows(2).map(|w| [w[0] + 1e-7, w[1] - 1e-7]).filter(|[from, to]| from < to).collect()
}

#[test]
fn densities_integrate_to_one_where_something_is_met() {
    let mut rng = Rng::new(2);
    let mut found = [0, 0];
    for i in 0..300 {
        let exponent = [0.0, 3.0, 20.0, 200.0][i % 4];
        let table = table(&mut rng, 6);
        let circle = any_circle(&mut rng, exponent);
        if table.lights().iter().any(|light| is_close(light, circle.point)) {
            continue;
        }
        let total: f64 = pieces(&table, &circle)
            .into_iter()
            .map(|piece| integrate_1d(|phi| density(&table, &circle, phi), piece, 16, 1e-6))
            .sum();
        let met = table.sample_circle(&circle, 0.5, [0.5; 2]).is_some();
        found[usize::from(met)] += 1;
        assert!((total - f64::from(u8::from(met))).abs() < 1e-3, "{total} {met}: {circle:?}");
    }
    assert!(found[1] > 100, "{found:?}");
}

/// What is sampled is distributed as stated, points at its light, and is seen from there.
#[test]
fn samples_follow_their_density() {
    let mut rng = Rng::new(3);
    let prove = std::env::var("ETENDUE_PROVE").is_ok_and(|v| v == "1");
    let (samples, circles) = if prove { (400_000, 60) } else { (20_000, 24) };
    for i in 0..circles {
        // Few lights that are looked at one by one, and many of which one is chosen.
        let exponent = [0.0, 8.0, 50.0][i % 3];
        let (table, circle) = loop {
            let table = table(&mut rng, if i % 3 == 2 { 40 } else { 5 });
            let circle = any_circle(&mut rng, exponent);
            if !table.lights().iter().any(|light| is_close(light, circle.point)) {
                break (table, circle);
            }
        };
        let sample = |rng: &mut Rng| {
            let (index, sample) = table.sample_circle(&circle, rng.f64(), rng.f32x2())?;
            let light = &table.lights()[index as usize];
            let target = sample.target.expect("lights at some place") - circle.point;
            let pdf = table.pdf_circle(&circle, index, sample.wi, target.length());
            let Density::Arc(own) = sample.density else { panic!("{:?}", sample.density) };
            assert!((pdf - own).abs() < 1e-4 * own || light_edge(light, &circle, sample.wi), "{own} {pdf}");
            // Targets are lifted off their light by some rounding errors.
            let slack = 1e-5 + 2e-5 / target.length();
            assert!(target.normalize().distance(sample.wi) < slack, "{light:?} {sample:?}");
            assert_eq!(sample.radiance, light.radiance());
            Some(circle.angle(sample.wi))
        };
        ChiSquare::new(samples)
            .cells(100)
            .seed(i as u64)
            .stray_fraction(1e-3)
            .interval([0.0, PI], sample, |phi| density(&table, &circle, phi))
            .assert(0.01, circles, &format!("circle {i}"));
    }
}

/// Within the rounding of a direction from the end of an arc.
fn light_edge(light: &Light, circle: &LightCircle, wi: Vec3) -> bool {
    let phi = circle.angle(wi);
    light.arcs(circle).iter().flatten().any(|end| (phi - end).abs() < 1e-5)
}

fn upright(exponent: f32) -> LightCircle {
    circle(Vec3::ZERO, Vec3::Z, Vec3::X, vec3(-0.6, 0.0, 0.8), exponent).unwrap()
}

fn rectangle(corner: Vec3, u: Vec3, v: Vec3) -> Light {
    Light::Rectangle(RectangleLight { corner, u, v, radiance: Spectrum::ONE, two_sided: false })
}

#[test]
fn lights_behind_below_and_in_line() {
    let arcs = |light: &Light| light.arcs(&upright(20.0)).iter().copied().collect::<Vec<_>>();
    let (x, y) = (2.0 * Vec3::X, 2.0 * Vec3::Y);
    let corner = vec3(-1.0, -1.0, 1.0);
    // Overhead, facing down: from 45 to 135 degrees.
    let above = arcs(&rectangle(corner, y, x));
    assert!(above.len() == 1 && (above[0][0] - PI / 4.0).abs() < 1e-9 && (above[0][1] - 0.75 * PI).abs() < 1e-9);
    assert!(arcs(&rectangle(corner, x, y)).is_empty(), "facing up");
    assert!(arcs(&rectangle(vec3(-1.0, -1.0, -1.0), x, y)).is_empty(), "below the surface");
    assert!(arcs(&rectangle(vec3(-1.0, 0.5, 1.0), y, x)).is_empty(), "beside the circle");
    assert!(arcs(&rectangle(vec3(-1.0, -1.0, 0.0), y, x)).is_empty(), "the point is in its plane");
    // A wall at x = 1 that goes from below the horizon to 45 degrees.
    let wall = arcs(&rectangle(vec3(1.0, -1.0, -5.0), 6.0 * Vec3::Z, y));
    assert!(wall.len() == 1 && wall[0][0] == 0.0 && (wall[0][1] - PI / 4.0).abs() < 1e-9, "{wall:?}");
    // A plate whose edge the circle grazes: all or nothing, no NaN.
    let edge = arcs(&rectangle(vec3(-1.0, 0.0, 1.0), y, x));
    assert!(edge.len() <= 1, "{edge:?}");
    // The circle's plane cuts a large sphere that the point is outside of, and the horizon cuts it too.
    let sphere = |center, radius, two_sided| {
        Light::Sphere(SphereLight { two_sided, ..SphereLight::round(center, radius, Spectrum::ONE) })
    };
    let low = arcs(&sphere(vec3(2.0, 0.0, 0.0), 1.0, false));
    assert!(low.len() == 1 && low[0][0] == 0.0 && (low[0][1] - PI / 6.0).abs() < 1e-7, "{low:?}");
    assert_eq!(arcs(&sphere(vec3(0.0, 0.0, 0.1), 1.0, true)), [[0.0, PI]], "inside");
    assert!(arcs(&sphere(vec3(0.0, 0.0, 0.1), 1.0, false)).is_empty(), "inside of what shines outward");
    assert!(arcs(&sphere(vec3(0.0, 3.0, 1.0), 1.0, false)).is_empty());
    // A small lamp far away has the width that it should.
    let far = arcs(&sphere(vec3(0.0, 0.0, 1e4), 1e-3, false));
    assert!(far.len() == 1 && ((far[0][1] - far[0][0]) / 2e-7 - 1.0).abs() < 1e-6, "{far:?}");
    // A triangle all around the circle but for a bite.
    let vertices = [vec3(-100.0, -50.0, 1.0), vec3(0.0, 100.0, 1.0), vec3(100.0, -50.0, 1.0)];
    let wide = arcs(&Light::Triangle(TriangleLight { vertices, radiance: Spectrum::ONE, two_sided: true }));
    assert!(wide.len() == 1 && wide[0][0] < 0.05 && wide[0][1] > PI - 0.05, "{wide:?}");
}

/// Degenerate and extreme lights give nothing or something sound.
#[test]
fn nothing_breaks_at_the_edges() {
    let mut rng = Rng::new(4);
    let sizes = [0.0, 1e-30, 1e-12, 1e-6, 1.0, 1e6, 1e15];
    let mut met = 0;
    for i in 0..30_000 {
        let exponent = [0.0, 1e-30, 1.0, 20.0, 1e4, 1e9][i % 6];
        let circle = any_circle(&mut rng, exponent);
        let mut size = || sizes[rng.u32() as usize % sizes.len()];
        let (far, wide, other) = (size(), size(), size());
        let at = vector(&mut rng, far);
        let (u, v) = (vector(&mut rng, wide), vector(&mut rng, other));
        let radiance = Spectrum::splat([1e-30, 1.0, 1e30][i % 3]);
        let light = match i % 3 {
            0 => Light::Triangle(TriangleLight { vertices: [at, at + u, at + v], radiance, two_sided: true }),
            1 => Light::Rectangle(RectangleLight { corner: at, u, v, radiance, two_sided: true }),
            _ => Light::Sphere(SphereLight { two_sided: true, ..SphereLight::round(at, wide as f32, radiance) }),
        };
        let Ok(table) = LightTable::new(vec![light], 1.0) else { continue };
        let u = [0.0, 1.0 - f32::EPSILON / 2.0, rng.f32()][rng.u32() as usize % 3];
        let Some((_, sample)) = table.sample_circle(&circle, f64::from(u), [u, 1.0 - f32::EPSILON / 2.0]) else {
            continue;
        };
        met += 1;
        assert!(sample.target.is_some_and(Vec3::is_finite) && (sample.wi.length() - 1.0).abs() < 1e-5);
        assert!(sample.density.value() > 0.0 && sample.density.value().is_finite());
        let pdf = table.pdf_circle(&circle, 0, sample.wi, 1.0);
        assert!(pdf.is_finite() && pdf >= 0.0);
    }
    assert!(met > 1000, "{met}");
}
