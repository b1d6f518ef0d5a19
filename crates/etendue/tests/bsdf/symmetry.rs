//! Reciprocity, and the surface seen from behind.

use crate::cases::{cases, draw, outgoing, random_direction};
use etendue::{
    bsdf::{Bsdf, BsdfEval, Density, fresnel},
    math::{Vec3, vec3},
};
use etendue_testkit::Rng;

/// f(wo, wi) / n_o^2 = f(wi, wo) / n_i^2 with n the index on a direction's side (Veach 1997, 5.2).
#[test]
fn continuous_lobes_are_reciprocal() {
    for case in cases() {
        let mut rng = Rng::new(5);
        let refracts = !matches!(case.bsdf, Bsdf::Diffuse(_));
        let index2 = |w: Vec3| if refracts { case.index_at(w) * case.index_at(w) } else { 1.0 };
        let mut found = 0;
        for wo in outgoing() {
            for k in 0..400 {
                let wi = if k % 2 == 0 {
                    random_direction(&mut rng)
                } else {
                    let Some(sample) = draw(&case.bsdf, wo, &mut rng) else { continue };
                    sample.wi
                };
                let (there, back) = (case.bsdf.eval(wo, wi).value, case.bsdf.eval(wi, wo).value);
                for c in 0..3 {
                    let a = there[c] / (wi.z.abs() * index2(wo));
                    let b = back[c] / (wo.z.abs() * index2(wi));
                    found += usize::from(a > 0.0);
                    // Far out in the tails facets are met at grazing angles, where f32 has few digits left of Fresnel's
                    // transmission.
                    let tolerance = if a.max(b) > 0.01 { 2e-3 * a.max(b) } else { 2e-2 * a.max(b) + 1e-6 };
                    assert!((a - b).abs() <= tolerance, "{}: {wo} {wi}: {a} and back {b}", case.name);
                }
            }
        }
        assert_eq!(found > 0, !case.bsdf.is_delta(), "{}", case.name);
    }
}

/// The way back along a discrete direction exists and carries as much: value n_i^2 / n_o^2 is the same share.
#[test]
fn discrete_lobes_are_reciprocal() {
    let mut rng = Rng::new(6);
    for case in cases() {
        for _ in 0..200 {
            let wo = random_direction(&mut rng);
            let Some(there) = draw(&case.bsdf, wo, &mut rng) else { continue };
            let Density::Discrete(probability) = there.density else { continue };
            if wo.z.abs() < 0.02 {
                // The way back is so close to the critical angle that the angle of f32 unit vectors is not precise enough.
                continue;
            }
            let share = there.weight * (probability * there.eta * there.eta);
            let mut seen = false;
            for _ in 0..2000 {
                let Some(back) = draw(&case.bsdf, there.wi, &mut rng) else { continue };
                let Density::Discrete(probability) = back.density else { continue };
                if back.transmitted != there.transmitted {
                    continue;
                }
                seen = true;
                assert!(back.wi.distance(wo) < 1e-3, "{}: {wo} {there:?} {back:?}", case.name);
                let share_back = back.weight * (probability * back.eta * back.eta);
                for c in 0..3 {
                    assert!((share[c] - share_back[c]).abs() < 1e-3, "{}: {there:?} {back:?}", case.name);
                }
                break;
            }
            let rare = share.max_component() < 0.01;
            assert!(seen || rare, "{}: {wo} {there:?}", case.name);
        }
    }
}

/// A turn of both directions about the normal changes what anisotropic surfaces scatter, and no others.
#[test]
fn only_anisotropic_surfaces_know_a_tangent() {
    let mut rng = Rng::new(8);
    // Brushed metal has nothing per steradian.
    for case in cases().iter().filter(|case| !matches!(case.bsdf, Bsdf::BrushedMetal(_))) {
        let mut differ = 0;
        for _ in 0..400 {
            let (wo, wi) = (random_direction(&mut rng), random_direction(&mut rng));
            let quarter = |v: Vec3| vec3(-v.y, v.x, v.z);
            let (a, b) = (case.bsdf.eval(wo, wi), case.bsdf.eval(quarter(wo), quarter(wi)));
            differ += usize::from(!close(a, b));
        }
        assert_eq!(differ > 0, case.bsdf.is_anisotropic(), "{}: {differ}", case.name);
    }
}

/// From behind a surface is the same surface with the inverse index.
#[test]
fn the_back_is_the_front_of_the_turned_surface() {
    let flip = |v: Vec3| vec3(v.x, v.y, -v.z);
    let mut rng = Rng::new(7);
    for case in cases() {
        let turned = case.turned();
        for wo in outgoing() {
            for _ in 0..100 {
                let wi = random_direction(&mut rng);
                let (front, back) = (case.bsdf.eval(wo, wi), turned.eval(flip(wo), flip(wi)));
                assert!(close(front, back), "{}: {front:?} {back:?}", case.name);
                let (u_lobe, u) = (rng.f32(), rng.f32x2());
                match (case.bsdf.sample(wo, u_lobe, u), turned.sample(flip(wo), u_lobe, u)) {
                    (None, None) => {}
                    (Some(a), Some(b)) => {
                        assert!(a.wi.distance(flip(b.wi)) < 1e-4, "{}: {a:?} {b:?}", case.name);
                        assert!((a.weight - b.weight).map(f32::abs).max_component() < 1e-3 * a.weight.max_component());
                        assert_eq!(a.transmitted, b.transmitted);
                    }
                    (a, b) => panic!("{}: {a:?} {b:?}", case.name),
                }
            }
        }
    }
}

fn close(a: BsdfEval, b: BsdfEval) -> bool {
    let near = |a: f32, b: f32| (a - b).abs() <= 1e-3 * a.max(b) + 1e-6;
    near(a.pdf, b.pdf) && (0..3).all(|c| near(a.value[c], b.value[c]))
}

/// What an interface does not reflect passes, as much one way as the other.
#[test]
fn transmittance_is_what_is_not_reflected() {
    for eta in [0.6f32, 0.9, 1.0001, 1.33, 1.5, 2.4] {
        for step in 1..=100u8 {
            let cos_i = f32::from(step) / 100.0;
            let interface = fresnel::dielectric(cos_i, eta);
            if interface.cos_t <= 0.0 {
                continue;
            }
            let there = fresnel::transmittance(cos_i, interface.cos_t, eta);
            let back = fresnel::transmittance(interface.cos_t, cos_i, 1.0 / eta);
            assert!((there - (1.0 - interface.reflectance)).abs() < 2e-6, "{eta} {cos_i}: {there}");
            assert!((there - back).abs() <= 1e-6 * there, "{eta} {cos_i}: {there} and back {back}");
        }
    }
}
