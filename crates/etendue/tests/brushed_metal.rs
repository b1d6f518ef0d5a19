//! The lobe of brushed metal against what it claims: energy, reciprocity, sampling in its own measure, limits.

#![allow(clippy::disallowed_methods)]

use etendue::{
    bsdf::{BrushedMetal, Bsdf, Circle, Density, GrooveForm},
    math::{Vec3, vec3},
    spectrum::Spectrum,
};
use etendue_testkit::{
    Moments, Rng,
    chi2::{ChiSquare, Drawn},
    integrate_1d, ttest,
};
use std::f64::consts::PI;

const FORMS: [GrooveForm; 2] = GrooveForm::ALL;
const EXPONENTS: [f32; 8] = [0.0, 0.3, 1.0, 2.0, 20.0, 300.0, 1e5, 1e9];

fn metal(exponent: f32, form: GrooveForm) -> Bsdf {
    Bsdf::BrushedMetal(BrushedMetal::new(Spectrum::ONE, exponent, form))
}

/// A direction at an angle on the circle (degrees, 0 and 180 being the horizon) with a component along the grooves.
fn outgoing(angle: f64, along: f64) -> Vec3 {
    let (radius, angle) = ((1.0 - along * along).sqrt(), angle.to_radians());
    vec3((radius * angle.cos()) as f32, along as f32, (radius * angle.sin()) as f32)
}

/// Directions from the normal to grazing, across the grooves and nearly along them, on both sides.
fn all_outgoing() -> impl Iterator<Item = Vec3> {
    let angles = [90.0, 120.0, 60.0, 17.0, 165.0, 2.0, 179.7];
    angles.into_iter().flat_map(|angle| {
        [(0.0, 1.0), (0.5, -1.0), (-0.97, 1.0)].map(|(along, side)| {
            let wo = outgoing(angle, along);
            vec3(wo.x, wo.y, wo.z * side)
        })
    })
}

fn circle(bsdf: &Bsdf, wo: Vec3) -> Circle {
    bsdf.circle(wo).expect("brushed metal scatters into a circle")
}

/// Integral over the circle; a lobe may be far narrower than it.
fn integral(circle: &Circle, exponent: f32, f: impl Fn(f64) -> f64) -> f64 {
    let reach = 16.0 / (f64::from(exponent) + 1.0).sqrt();
    let ends = [(circle.mirror - reach).max(0.0), (circle.mirror + reach).min(PI)];
    // The reciprocal form has a bend where sin(phi) = sin(a).
    let bends = [ends[0], circle.mirror.clamp(ends[0], ends[1]), (PI - circle.mirror).clamp(ends[0], ends[1]), ends[1]];
    let mut bends = bends.to_vec();
    bends.sort_by(f64::total_cmp);
    bends.windows(2).filter(|w| w[1] > w[0]).map(|w| integrate_1d(&f, [w[0], w[1]], 64, 1e-9)).sum()
}

fn albedo(bsdf: &Bsdf, exponent: f32, wo: Vec3) -> f64 {
    let circle = circle(bsdf, wo);
    integral(&circle, exponent, |phi| f64::from(circle.eval(phi).value[0]))
}

#[test]
fn the_normalised_form_scatters_all_and_the_reciprocal_no_more() {
    for exponent in EXPONENTS {
        for wo in all_outgoing() {
            let (reciprocal, normalised) = (metal(exponent, FORMS[0]), metal(exponent, FORMS[1]));
            let all = albedo(&normalised, exponent, wo);
            assert!((all - 1.0).abs() < 1e-5, "{exponent} {wo}: {all}");
            let some = albedo(&reciprocal, exponent, wo);
            assert!(some > 0.0 && some <= 1.0 + 1e-5, "{exponent} {wo}: {some}");
        }
    }
}

/// The factors of a floor's darkness that the models' page states.
#[test]
fn albedo_of_the_reciprocal_form() {
    let reciprocal = metal(20.0, GrooveForm::Reciprocal);
    for (elevation, expected) in [(90.0, 0.91), (17.0, 0.63)] {
        let found = albedo(&reciprocal, 20.0, outgoing(elevation, 0.0));
        assert!((found - expected).abs() < 0.005, "{elevation}: {found}");
        // The same elevation within the circle, whatever the component along the grooves.
        let along = albedo(&reciprocal, 20.0, outgoing(elevation, 0.8));
        assert!((found - along).abs() < 1e-6);
    }
}

/// f(wo, wi) without its cosine is the same with both exchanged: the value per radian over the sine of phi (the radius of the
/// circle is the same from both ends).
#[test]
fn the_default_form_is_reciprocal_and_the_other_is_not() {
    let mut rng = Rng::new(3);
    let mut differ = 0;
    for i in 0..4000 {
        let exponent = EXPONENTS[i % 6];
        let wo = outgoing(rng.range(1.0, 179.0), rng.range(-0.95, 0.95));
        let phi = rng.range(0.01, PI - 0.01);
        for form in FORMS {
            let bsdf = metal(exponent, form);
            let there = circle(&bsdf, wo);
            let wi = there.direction(phi);
            let back = circle(&bsdf, wi);
            // The angle of wo on the circle of wi, which runs the other way round.
            let angle_back = f64::from(wo.z).atan2(f64::from(wo.x));
            let a = f64::from(there.eval(phi).value[0]) / phi.sin();
            let b = f64::from(back.eval(angle_back).value[0]) / angle_back.sin();
            assert!((back.direction(angle_back) - wo).length() < 1e-5);
            let same = (a - b).abs() <= 2e-4 * a.max(b) + 1e-9;
            match form {
                GrooveForm::Reciprocal => assert!(same, "{exponent} {wo} {phi}: {a} and back {b}"),
                GrooveForm::Normalised => differ += usize::from(!same),
            }
        }
    }
    assert!(differ > 1000, "{differ}");
}

fn angle_of(circle: &Circle, wi: Vec3) -> f64 {
    (f64::from(wi.z) * circle.side).atan2(f64::from(wi.x))
}

#[test]
fn samples_follow_their_density_per_radian() {
    let prove = std::env::var("ETENDUE_PROVE").is_ok_and(|v| v == "1");
    let samples = if prove { 1_000_000 } else { 40_000 };
    let cases: Vec<(f32, GrooveForm, Vec3)> = EXPONENTS
        .into_iter()
        .flat_map(|exponent| FORMS.map(|form| (exponent, form)))
        .flat_map(|(exponent, form)| all_outgoing().map(move |wo| (exponent, form, wo)))
        .collect();
    let of_cases = cases.len();
    for (i, (exponent, form, wo)) in cases.into_iter().enumerate() {
        if !prove && i % 3 != 0 {
            continue;
        }
        let (bsdf, what) = (metal(exponent, form), format!("{exponent} {form:?} from {wo}"));
        let circle = circle(&bsdf, wo);
        // Lobes that are narrow for the digits of a direction in f32 are looked at as they are.
        let reach = 16.0 / (f64::from(exponent) + 1.0).sqrt();
        let range = [(circle.mirror - reach).max(0.0), (circle.mirror + reach).min(PI)];
        let sample = |rng: &mut Rng| match bsdf.sample(wo, rng.f32(), rng.f32x2()) {
            None => Drawn::Nothing,
            Some(sample) => {
                let phi = angle_of(&circle, sample.wi);
                let Density::Arc(density) = sample.density else { panic!("{what}: {sample:?}") };
                let eval = circle.eval(phi);
                // The angle of a direction in f32 is known to 1e-7.
                let slack = 2e-7 * (f64::from(exponent) * 40.0).sqrt();
                let tolerance = (1e-5 + slack) * f64::from(density);
                assert!(f64::from((eval.pdf - density).abs()) <= tolerance, "{what}: {sample:?} {eval:?}");
                for c in 0..3 {
                    let weight = eval.value[c] / eval.pdf;
                    assert!((weight - sample.weight[c]).abs() < 2e-4, "{what}: {sample:?} {eval:?}");
                }
                assert!((sample.wi.y + wo.y).abs() < 1e-6 && !sample.transmitted);
                Drawn::Point(phi)
            }
        };
        ChiSquare::new(samples)
            .cells(if exponent > 1e8 { 60 } else { 200 })
            .seed(i as u64)
            .interval(range, sample, |phi| f64::from(circle.eval(phi).pdf))
            .assert(0.01, of_cases, &what);
    }
}

/// The reciprocal form takes a pair of numbers, the normalised form the first of it; neither asks for the lobe's.
#[test]
fn sampling_takes_a_fixed_number_of_numbers() {
    let mut rng = Rng::new(4);
    for form in FORMS {
        let bsdf = metal(20.0, form);
        for wo in all_outgoing() {
            let u = rng.f32x2();
            let first = bsdf.sample(wo, 0.1, u);
            assert_eq!(first, bsdf.sample(wo, 0.9, u));
            if form == GrooveForm::Normalised {
                assert_eq!(first, bsdf.sample(wo, 0.1, [u[0], 0.123]));
                assert!(first.is_some(), "nothing is lost");
            }
        }
    }
}

#[test]
fn large_exponents_tend_to_a_mirror() {
    let mut rng = Rng::new(5);
    for form in FORMS {
        for wo in all_outgoing() {
            let mirrored = vec3(-wo.x, -wo.y, wo.z);
            let mut distance = Moments::new();
            for (exponent, limit) in [(1e3, 0.5), (1e6, 0.02), (1e9, 5e-4)] {
                for _ in 0..50 {
                    let Some(sample) = metal(exponent, form).sample(wo, 0.0, rng.f32x2()) else { continue };
                    distance.push(f64::from(sample.wi.distance(mirrored)));
                    assert!(sample.wi.distance(mirrored) < limit, "{exponent} {wo}: {}", sample.wi);
                }
            }
            let share = albedo(&metal(1e9, form), 1e9, wo);
            assert!((share - 1.0).abs() < 0.01 || wo.z.abs() < 0.01, "{wo}: {share}");
        }
    }
}

/// The paper prints Z / |d| <d, n>^k with d from the sum of both directions: not of unit length. For large k that is largest at
/// the top of the circle, whatever the mirror direction. With d of unit length it tends to the mirror direction.
#[test]
fn the_printed_lobe_does_not_tend_to_a_mirror() {
    let (radius, elevation) = (1.0, 0.5f64);
    let wo = [-radius * elevation.cos(), radius * elevation.sin()];
    let mean = |normalise: bool, k: f64| {
        let (mut sum, mut weight) = (0.0, 0.0);
        for i in 1..20_000 {
            let phi = PI * f64::from(i) / 20_000.0;
            let d = [wo[0] + radius * phi.cos(), wo[1] + radius * phi.sin()];
            let length = d[0].hypot(d[1]);
            let lobe = if normalise { (d[1] / length).powf(k) } else { (d[1] / (radius + wo[1])).powf(k) / length };
            sum += lobe * phi;
            weight += lobe;
        }
        sum / weight
    };
    // Light that arrives low leaves straight up in the printed lobe, instead of low on the other side.
    assert!((mean(false, 1e4) - PI / 2.0).abs() < 0.01, "{}", mean(false, 1e4));
    assert!((mean(true, 1e4) - elevation).abs() < 0.01, "{}", mean(true, 1e4));
    let seen = circle(&metal(1e4, GrooveForm::Normalised), vec3(wo[0] as f32, 0.0, wo[1] as f32));
    assert!((seen.mirror - elevation).abs() < 1e-6);
}

/// Sampling and the integral of eval agree in how much is scattered.
#[test]
fn white_furnace() {
    let mut rng = Rng::new(6);
    for exponent in EXPONENTS {
        for form in FORMS {
            let bsdf = metal(exponent, form);
            for wo in all_outgoing() {
                let mut seen = Moments::new();
                for _ in 0..4000 {
                    seen.push(bsdf.sample(wo, 0.0, rng.f32x2()).map_or(0.0, |s| f64::from(s.weight[0])));
                }
                let expected = albedo(&bsdf, exponent, wo);
                assert!(seen.mean() <= 1.0 + 1e-6, "{exponent} {form:?} {wo}: {}", seen.mean());
                let error = 5.0 * seen.standard_error() + 2e-4;
                assert!(
                    (seen.mean() - expected).abs() <= error,
                    "{exponent} {form:?} {wo}: {} {expected}",
                    seen.mean()
                );
            }
        }
    }
    // And the same with a test of its mean where much is lost.
    let bsdf = metal(2.0, GrooveForm::Reciprocal);
    let wo = outgoing(40.0, 0.3);
    let draws = (0..200_000).map(|_| bsdf.sample(wo, 0.0, rng.f32x2()).map_or(0.0, |s| f64::from(s.weight[0])));
    ttest::t_test(&draws.collect(), albedo(&bsdf, 2.0, wo)).assert(0.001, "furnace");
}

/// The surface looks the same from behind.
#[test]
fn both_sides_scatter_alike() {
    let bsdf = metal(20.0, GrooveForm::Reciprocal);
    let flip = |v: Vec3| vec3(v.x, v.y, -v.z);
    for wo in all_outgoing() {
        let (front, back) = (bsdf.sample(wo, 0.0, [0.3, 0.2]), bsdf.sample(flip(wo), 0.0, [0.3, 0.2]));
        assert_eq!(front.map(|s| (s.wi, s.density)), back.map(|s| (flip(s.wi), s.density)));
        assert_eq!(circle(&bsdf, wo).direction(1.0), flip(circle(&bsdf, flip(wo)).direction(1.0)));
    }
    assert!(bsdf.circle(Vec3::X).is_none() && bsdf.circle(Vec3::Y).is_none());
}
