//! Every phase function against what must hold for all of them, and each against where it comes from.

use etendue::{
    math::{Frame, Vec3, vec3},
    medium::{PhaseComponent, PhaseError, PhaseFunction, PhaseKind},
    sampling::warp,
};
use etendue_testkit::{
    Rng,
    chi2::{ChiSquare, Drawn},
    integrate_1d, sidak,
    ttest::{Moments, t_test},
};
use std::f64::consts::{PI, TAU};

fn henyey_greenstein(g: f32) -> PhaseKind {
    PhaseKind::HenyeyGreenstein { g }
}

fn component(kind: PhaseKind, weight: f32) -> PhaseComponent {
    PhaseComponent { kind, weight }
}

/// All shapes and mixtures. The match has no wildcard: a new shape does not compile until someone has thought of it here.
fn cases() -> Vec<(String, PhaseFunction)> {
    let mut kinds = Vec::new();
    for kind in PhaseKind::ALL {
        match kind {
            PhaseKind::Isotropic | PhaseKind::LambertSphere | PhaseKind::HalfCosine | PhaseKind::Rayleigh => {
                kinds.push(kind);
            }
            PhaseKind::HenyeyGreenstein { .. } => {
                kinds.extend([-0.999, -0.7, -1e-4, 0.0, 1e-30, 1e-6, 0.3, 0.9, 0.999].map(henyey_greenstein));
            }
        }
    }
    let mut cases: Vec<_> = kinds.iter().map(|&kind| (format!("{kind:?}"), PhaseFunction::from(kind))).collect();
    let cloud = [component(henyey_greenstein(0.85), 9.0), component(henyey_greenstein(-0.3), 1.0)];
    let odd = [
        component(PhaseKind::Rayleigh, 0.0),
        component(PhaseKind::LambertSphere, 1e-3),
        component(PhaseKind::HalfCosine, 2e-3),
        component(henyey_greenstein(0.5), 0.5e-3),
        component(PhaseKind::Isotropic, 0.0),
    ];
    cases.push(("cloud".to_owned(), PhaseFunction::mixture(&cloud).unwrap()));
    cases.push(("odd".to_owned(), PhaseFunction::mixture(&odd).unwrap()));
    cases
}

fn directions() -> [Vec3; 4] {
    [vec3(0.0, 0.0, 1.0), vec3(0.0, 0.0, -1.0), vec3(0.6, 0.0, -0.8), vec3(-0.48, 0.64, 0.6)]
}

/// The value at an angle from straight on.
fn value(phase: &PhaseFunction, angle: f64) -> f64 {
    f64::from(phase.eval(vec3(0.0, 0.0, -1.0), vec3(angle.sin() as f32, 0.0, angle.cos() as f32)))
}

#[test]
fn samples_follow_their_density() {
    let prove = std::env::var("ETENDUE_PROVE").is_ok_and(|v| v == "1");
    let (samples, cells) = if prove { (2_000_000, 1000) } else { (100_000, 300) };
    let cases = cases();
    let tests = cases.len() * directions().len();
    for (i, (name, phase)) in cases.iter().enumerate() {
        for (j, wo) in directions().into_iter().enumerate() {
            let sample = |rng: &mut Rng| {
                let wi = phase.sample(wo, rng.f32(), rng.f32x2()).wi;
                Drawn::Point(wi.to_array().map(f64::from))
            };
            let pdf = |w: [f64; 3]| f64::from(phase.eval(wo, vec3(w[0] as f32, w[1] as f32, w[2] as f32)));
            ChiSquare::new(samples).cells(cells).seed((10 * i + j) as u64).sphere(sample, pdf).assert(
                0.01,
                tests,
                &format!("{name} from {wo}"),
            );
        }
    }
}

#[test]
fn densities_integrate_to_one() {
    for (name, phase) in cases() {
        // By the fourth power of the angle's share, so that narrow lobes ahead are resolved; and the same from behind.
        let half = |flip: bool| {
            let f = |t: f64| {
                let angle = 0.5 * PI * t.powi(4);
                let jacobian = 0.5 * PI * 4.0 * t.powi(3);
                value(&phase, if flip { PI - angle } else { angle }) * angle.sin() * TAU * jacobian
            };
            integrate_1d(f, [0.0, 1.0], 64, 1e-9)
        };
        let sum = half(false) + half(true);
        assert!((sum - 1.0).abs() < 1e-5, "{name}: {sum}");
    }
}

#[test]
fn mean_cosines_are_known() {
    for (kind, mean) in [
        (PhaseKind::Isotropic, 0.0),
        (PhaseKind::LambertSphere, -4.0 / 9.0),
        (PhaseKind::HalfCosine, -0.2),
        (henyey_greenstein(0.6), 0.6),
        (henyey_greenstein(-0.25), -0.25),
        (PhaseKind::Rayleigh, 0.0),
    ] {
        let phase = PhaseFunction::from(kind);
        let integral = integrate_1d(|a| value(&phase, a) * a.cos() * a.sin() * TAU, [0.0, PI], 64, 1e-9);
        assert!((integral - mean).abs() < 1e-5, "{kind:?}: {integral}");
        assert!((f64::from(phase.mean_cosine()) - mean).abs() < 1e-6, "{kind:?}");
    }
    for (name, phase) in cases() {
        let mut rng = Rng::new(5);
        let wo = vec3(0.6, 0.0, -0.8);
        let cosines = (0..100_000).map(|_| f64::from(-phase.sample(wo, rng.f32(), rng.f32x2()).wi.dot(wo)));
        let cosines: Moments = cosines.collect();
        let mean = f64::from(phase.mean_cosine());
        t_test(&cosines, mean).assert(sidak(0.01, cases().len()), &name);
    }
}

/// The same whichever way light goes, and the same in every frame.
#[test]
fn values_are_reciprocal() {
    let mut rng = Rng::new(7);
    for (name, phase) in cases() {
        for _ in 0..2000 {
            let [a, b] = [0; 2].map(|_| Vec3::from(rng.direction().map(|x| x as f32)).normalize());
            let (there, back) = (phase.eval(a, b), phase.eval(b, a));
            assert_eq!(there.to_bits(), back.to_bits(), "{name}");
            assert!(there >= 0.0 && there.is_finite());
            let turned = phase.eval(-a, -b);
            assert!((turned - there).abs() <= 1e-6 * there, "{name}");
        }
    }
}

/// The stated density is that of the direction, and directions have unit length, to the ends of the random numbers.
#[test]
fn samples_state_their_density() {
    const LAST: f32 = 1.0 - f32::EPSILON / 2.0;
    let ends = [0.0, 1e-30, 6e-8, 1e-3, 0.25, 0.5, 0.75, 0.999, LAST];
    for (name, phase) in cases() {
        for wo in directions() {
            for lobe in ends {
                for u in ends {
                    for v in ends {
                        let sample = phase.sample(wo, lobe, [u, v]);
                        assert!((sample.wi.length() - 1.0).abs() < 1e-6, "{name}: {sample:?}");
                        assert!(sample.pdf > 0.0 || u == LAST || u == 0.0, "{name}: {u} {sample:?}");
                        let value = phase.eval(wo, sample.wi);
                        // Narrow lobes are as steep as a direction's rounding lets them be; a density that vanishes towards
                        // straight on does so with the cube of an angle.
                        let tolerance = if name.contains("999") { 1e-2 } else { 2e-5 };
                        assert!(
                            (value - sample.pdf).abs() <= tolerance * sample.pdf + 1e-7,
                            "{name} at {u}: {value} {sample:?}"
                        );
                    }
                }
            }
        }
    }
}

/// Lobes so narrow that single precision does not resolve them still draw unit vectors and state finite densities.
#[test]
fn the_narrowest_lobes_stay_finite() {
    const LARGEST: f32 = 1.0 - f32::EPSILON / 2.0;
    let mut rng = Rng::new(8);
    for g in [LARGEST, -LARGEST, 0.999_999, -0.999_999, f32::MIN_POSITIVE, 1e-45] {
        let phase = PhaseFunction::from(henyey_greenstein(g));
        assert_eq!(phase.components()[0].kind, henyey_greenstein(g));
        for _ in 0..10_000 {
            let wo = Vec3::from(rng.direction().map(|x| x as f32)).normalize();
            let sample = phase.sample(wo, rng.f32(), rng.f32x2());
            assert!((sample.wi.length() - 1.0).abs() < 1e-6 && sample.pdf > 0.0 && sample.pdf.is_finite(), "{g}");
            let straight = sample.wi.dot(wo) * -g.signum();
            assert!(g.abs() < 0.9 || straight > 0.999 || sample.pdf < 1.0, "{g}: {sample:?}");
            let value = phase.eval(wo, sample.wi);
            assert!(value > 0.0 && value.is_finite(), "{g}");
        }
    }
    for wild in [f32::NAN, f32::INFINITY, 1.0, -7.0] {
        let value = PhaseFunction::from(henyey_greenstein(wild)).eval(Vec3::X, -Vec3::X);
        assert!(value >= 0.0 && value.is_finite());
    }
}

/// A cosine-distributed direction about a normal that is cosine-distributed about the direction back: light that hits a tiny
/// matte ball, and leaves it.
fn from_a_matte_ball(wi: Vec3, rng: &mut Rng) -> Vec3 {
    let normal = Frame::from_normal(wi).to_world(warp::cosine_hemisphere(rng.f32x2()));
    Frame::from_normal(normal).to_world(warp::cosine_hemisphere(rng.f32x2()))
}

#[test]
fn lambert_sphere_is_the_light_from_a_matte_ball() {
    let phase = PhaseFunction::from(PhaseKind::LambertSphere);
    let wi = vec3(0.6, 0.0, -0.8);
    let sample = |rng: &mut Rng| Drawn::Point(from_a_matte_ball(wi, rng).to_array().map(f64::from));
    let pdf = |w: [f64; 3]| f64::from(phase.eval(vec3(w[0] as f32, w[1] as f32, w[2] as f32), wi));
    ChiSquare::new(400_000).sphere(sample, pdf).assert(0.01, 1, "matte ball");
}

/// The inversion is exact: the distribution function of the drawn angle is the number that drew it.
#[test]
fn lambert_sphere_inverts_its_distribution() {
    let phase = PhaseFunction::from(PhaseKind::LambertSphere);
    let wo = Vec3::Z;
    let distribution =
        |a: f64| 4.0 / (3.0 * PI) * (0.5 * a - 0.375 * (2.0 * a).sin() + 0.25 * (PI - (PI - a) * (2.0 * a).cos()));
    let mut last = -1.0;
    for i in 0..100_000 {
        let u = i as f32 / 100_000.0;
        let wi = phase.sample(wo, 0.0, [u, 0.3]).wi.as_dvec3();
        let angle = wi.truncate().length().atan2(wi.z);
        assert!(angle > last - 1e-6, "neighbours stay in order at {u}");
        last = angle;
        assert!((distribution(angle) - f64::from(u)).abs() < 3e-7, "{u}: {angle}");
    }
}

/// The paper has cos(theta / 2) as the phase function of such a ball and does not say from where theta is counted. From the
/// direction back it has the trend of the truth, though not its strength; from straight on it is worse than nothing.
#[test]
fn half_cosine_measured_forward_has_the_wrong_trend() {
    let mut rng = Rng::new(3);
    let wi = Vec3::Z;
    let cosines: Moments = (0..200_000).map(|_| f64::from(-from_a_matte_ball(wi, &mut rng).dot(wi))).collect();
    t_test(&cosines, -4.0 / 9.0).assert(0.01, "mean cosine of light from a matte ball");

    let exact = PhaseFunction::from(PhaseKind::LambertSphere);
    let paper = PhaseFunction::from(PhaseKind::HalfCosine);
    let distance = |other: &dyn Fn(f64) -> f64| {
        integrate_1d(|a| (other(a) - value(&exact, a)).powi(2) * a.sin(), [0.0, PI], 64, 1e-9)
    };
    let back = distance(&|a| value(&paper, a));
    let forward = distance(&|a| value(&paper, PI - a));
    let isotropic = distance(&|_| 0.25 / PI);
    assert!(back < 0.6 * isotropic && forward > 1.5 * isotropic, "{back} {isotropic} {forward}");
}

#[test]
fn mixtures_take_weights_of_any_sum() {
    let kinds = [PhaseKind::Rayleigh, henyey_greenstein(0.5)];
    for scale in [1e-30, 1.0, 3e38] {
        let phase = PhaseFunction::mixture(&[component(kinds[0], scale), component(kinds[1], 0.25 * scale)]).unwrap();
        let weights: Vec<f32> = phase.components().iter().map(|c| c.weight).collect();
        assert!((weights[0] - 0.8).abs() < 1e-6 && (weights[1] - 0.2).abs() < 1e-6, "{scale}: {weights:?}");
        let parts = kinds.map(|kind| PhaseFunction::from(kind).eval(Vec3::X, Vec3::Y));
        assert!((phase.eval(Vec3::X, Vec3::Y) - (0.8 * parts[0] + 0.2 * parts[1])).abs() < 1e-7);
    }
    let mixture = |weights: &[f32]| {
        let parts: Vec<_> = weights.iter().map(|w| component(PhaseKind::Rayleigh, *w)).collect();
        PhaseFunction::mixture(&parts)
    };
    assert_eq!(mixture(&[]), Err(PhaseError::Count(0)));
    assert_eq!(mixture(&[1.0; 17]), Err(PhaseError::Count(17)));
    assert_eq!(mixture(&[0.0, 0.0]), Err(PhaseError::NoWeight));
    assert_eq!(mixture(&[1.0, -1.0]), Err(PhaseError::Weight(-1.0)));
    assert!(matches!(mixture(&[f32::NAN]), Err(PhaseError::Weight(_))));
    assert!(matches!(mixture(&[f32::INFINITY]), Err(PhaseError::Weight(_))));
    for g in [1.0, -1.0, 2.0, f32::NAN] {
        let found = PhaseFunction::mixture(&[component(henyey_greenstein(g), 1.0)]);
        assert!(matches!(found, Err(PhaseError::MeanCosine(_))), "{g}");
    }
}
