//! Whole paths through glass bodies, with answers in closed form.

use crate::cases::{direction, random_direction};
use etendue::{
    bsdf::{Bsdf, fresnel},
    material::Scattering,
    math::{Frame, Vec3},
    spectrum::Spectrum,
};
use etendue_testkit::{Moments, Rng, ttest};

fn clear_glass(ior: f32, thin: bool) -> Bsdf {
    Scattering::Glass { ior, reflection_tint: Spectrum::ONE, transmission_tint: Spectrum::ONE, thin }.bsdf()
}

/// Follows a path from the point `p` of the unit sphere, the surface being met along `ray`, until it leaves. The
/// weight, and its radiance scale (index outside over that at the start, squared).
fn leave_sphere(bsdf: &Bsdf, mut p: Vec3, mut ray: Vec3, rng: &mut Rng) -> f32 {
    let mut weight = 1.0;
    for _ in 0..100_000 {
        let frame = Frame::from_normal(p);
        let Some(sample) = bsdf.sample(frame.to_local(-ray), rng.f32(), rng.f32x2()) else { return 0.0 };
        weight *= sample.weight.mean();
        ray = frame.to_world(sample.wi);
        if sample.wi.z > 0.0 {
            return weight;
        }
        p = (p - ray * (2.0 * p.dot(ray))).normalize();
    }
    panic!("caught in the sphere");
}

/// A ray that meets the sphere from outside, uniform over its cross section.
fn incoming(rng: &mut Rng) -> (Vec3, Vec3) {
    let ray = random_direction(rng);
    loop {
        let p = random_direction(rng);
        let cos = -p.dot(ray);
        if cos > 0.0 && rng.f32() < cos {
            return (p, ray);
        }
    }
}

/// A sphere of clear glass in an environment of radiance 1 cannot be seen: every path carries 1.
#[test]
fn clear_sphere_in_a_furnace_is_invisible() {
    for ior in [1.5, 1.0, 0.7, 2.4] {
        let mut rng = Rng::new(8);
        for _ in 0..20_000 {
            let (p, ray) = incoming(&mut rng);
            let weight = leave_sphere(&clear_glass(ior, false), p, ray, &mut rng);
            assert!((weight - 1.0).abs() < 1e-4, "ior {ior}: {weight}");
        }
    }
}

/// Seen from inside, the radiance of the environment is larger by the square of the index.
#[test]
fn furnace_seen_from_inside_glass() {
    for ior in [1.5f32, 0.7, 2.4] {
        let mut rng = Rng::new(9);
        for _ in 0..20_000 {
            // A ray from a point off the centre, so that total internal reflection does not keep it for ever.
            let from = random_direction(&mut rng) * 0.3;
            let ray = random_direction(&mut rng);
            let b = from.dot(ray);
            let p = from + ray * ((b * b + 1.0 - from.length_squared()).sqrt() - b);
            let weight = leave_sphere(&clear_glass(ior, false), p.normalize(), ray, &mut rng);
            assert!((weight / (ior * ior) - 1.0).abs() < 1e-4, "ior {ior}: {weight}");
        }
    }
}

/// A rough sphere loses what would meet a second facet, and never gains.
#[test]
fn rough_sphere_in_a_furnace_is_darker() {
    for (alpha, least) in [(0.01, 0.99), (0.1, 0.92), (0.5, 0.5)] {
        let rough = Scattering::RoughGlass {
            ior: 1.5,
            alpha,
            reflection_tint: Spectrum::ONE,
            transmission_tint: Spectrum::ONE,
        }
        .bsdf();
        let mut rng = Rng::new(10);
        let mut seen = Moments::new();
        for _ in 0..40_000 {
            let (p, ray) = incoming(&mut rng);
            seen.push(f64::from(leave_sphere(&rough, p, ray, &mut rng)));
        }
        let error = 4.0 * seen.standard_error();
        assert!(seen.mean() < 1.0 + error && seen.mean() > least, "alpha {alpha}: {} +- {error}", seen.mean());
    }
}

/// A slab of two interfaces: every path carries 1, and the share that comes back is 2 R / (1 + R), which the thin sheet
/// states directly.
#[test]
fn slab_is_the_thin_sheet() {
    let (slab, sheet) = (clear_glass(1.5, false), clear_glass(1.5, true));
    for theta in [0.0, 40.0, 75.0, 85.0] {
        let wo = direction(theta, 30.0, 1.0);
        let face = f64::from(fresnel::dielectric(wo.z, 1.5).reflectance);
        let expected = 2.0 * face / (1.0 + face);
        let mut rng = Rng::new(12);
        let mut returned = [Moments::new(), Moments::new()];
        for _ in 0..40_000 {
            let through_slab = slab_path(&slab, wo, &mut rng);
            assert!((through_slab.0 - 1.0).abs() < 1e-5);
            returned[0].push(f64::from(u8::from(through_slab.1)));
            let sample = sheet.sample(wo, rng.f32(), rng.f32x2()).unwrap();
            assert!((sample.weight.mean() - 1.0).abs() < 1e-6 && sample.eta == 1.0);
            assert!(sample.wi.distance(if sample.transmitted { -wo } else { Vec3::new(-wo.x, -wo.y, wo.z) }) < 1e-6);
            returned[1].push(f64::from(u8::from(!sample.transmitted)));
        }
        for moments in returned {
            ttest::t_test(&moments, expected).assert(0.001, &format!("{theta} degrees"));
        }
    }
}

/// A path through a slab of glass with faces across z: its weight, and whether it came back to the side of `wo`.
fn slab_path(glass: &Bsdf, wo: Vec3, rng: &mut Rng) -> (f32, bool) {
    let mut weight = 1.0;
    let mut towards = wo;
    let mut front = true;
    loop {
        // The far face has its outside at z < 0: turn the frame about x.
        let turn = |v: Vec3| if front { v } else { Vec3::new(v.x, -v.y, -v.z) };
        let sample = glass.sample(turn(towards), rng.f32(), rng.f32x2()).unwrap();
        weight *= sample.weight.mean();
        if sample.wi.z > 0.0 {
            return (weight, front);
        }
        towards = -turn(sample.wi);
        front = !front;
    }
}
