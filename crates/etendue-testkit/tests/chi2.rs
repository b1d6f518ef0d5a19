//! The chi-square test passes right samplers, fails wrong ones, and has uniform p-values.
#![allow(clippy::disallowed_methods)]

use std::f64::consts::{PI, TAU};

use etendue_testkit::chi2::{ChiSquare, Drawn};
use etendue_testkit::special::kolmogorov_uniform;
use etendue_testkit::{Rng, integrate_1d};

/// A lobe of density (n + 1) / (2 pi) cos^n about the axis at polar angle `tilt`.
#[allow(clippy::type_complexity)]
fn lobe(n: f64, tilt: f64) -> (impl Fn(&mut Rng) -> Option<[f64; 3]>, impl Fn([f64; 3]) -> f64) {
    let (s, c) = tilt.sin_cos();
    let sample = move |rng: &mut Rng| {
        let z = (1.0 - rng.f64()).powf(1.0 / (n + 1.0));
        let (r, phi) = ((1.0 - z * z).sqrt(), TAU * rng.f64());
        let (x, y) = (r * phi.cos(), r * phi.sin());
        Some([c * x + s * z, y, c * z - s * x])
    };
    let pdf = move |w: [f64; 3]| {
        let cosine = s * w[0] + c * w[2];
        if cosine > 0.0 { (n + 1.0) / TAU * cosine.powf(n) } else { 0.0 }
    };
    (sample, pdf)
}

#[test]
fn right_lobes_pass_however_narrow() {
    for (i, &(n, tilt)) in [(0.0, 0.3), (1.0, 1.0), (100.0, 1.4), (1e4, 0.7), (1e6, 2.0), (1e6, 0.0)].iter().enumerate()
    {
        let (sample, pdf) = lobe(n, tilt);
        ChiSquare::new(200_000).seed(i as u64).sphere(sample, pdf).assert(0.01, 6, &format!("lobe {n} {tilt}"));
    }
}

#[test]
fn wrong_lobes_fail() {
    for (n, wrong) in [(1.0, 1.04), (1e4, 1.02e4)] {
        let (sample, _) = lobe(n, 0.7);
        let (_, pdf) = lobe(wrong, 0.7);
        assert!(ChiSquare::new(1_000_000).sphere(sample, pdf).check(0.01, 100).is_err(), "{n}");
    }
    // One degree off.
    let (sample, _) = lobe(10.0, 0.7);
    let (_, pdf) = lobe(10.0, 0.7 + 0.02);
    assert!(ChiSquare::new(200_000).sphere(sample, pdf).check(0.01, 100).is_err());
}

#[test]
fn a_density_of_wrong_mass_fails() {
    let (sample, pdf) = lobe(20.0, 0.5);
    let report = ChiSquare::new(20_000).sphere(sample, |w| 1.01 * pdf(w)).check(0.01, 1).unwrap_err();
    assert!(report.contains("integrates to 1.01"), "{report}");
    // A part that the sampler never reaches.
    let (sample, pdf) = lobe(20.0, 0.5);
    let other = lobe(200.0, 2.5).1;
    let report = ChiSquare::new(100_000).sphere(sample, |w| 0.99 * pdf(w) + 0.01 * other(w)).check(0.01, 1);
    assert!(report.is_err());
}

#[test]
fn failures_are_part_of_the_law() {
    // Of a lobe that dips below the horizon only the upper part is drawn.
    let upper = |wrong: f64| {
        let (sample, pdf) = lobe(3.0, 1.2);
        ChiSquare::new(200_000).hemisphere(
            move |rng: &mut Rng| {
                let lost = rng.f64() < wrong;
                sample(rng).filter(|w| w[2] >= 0.0 && !lost)
            },
            pdf,
        )
    };
    upper(0.0).assert(0.01, 1, "upper part");
    assert!(upper(0.0).failed > 1000);
    assert!(upper(0.01).check(0.01, 100).is_err());
    // Points below the horizon are outside of a hemisphere.
    let (sample, pdf) = lobe(3.0, 1.2);
    let report = ChiSquare::new(10_000).hemisphere(sample, pdf).check(0.01, 1).unwrap_err();
    assert!(report.contains("outside"), "{report}");
}

#[test]
fn discrete_mass_beside_a_density() {
    let run = |share: f64| {
        ChiSquare::new(200_000).discrete(&[0.3, 0.2]).interval(
            [-1.0, 3.0],
            move |rng: &mut Rng| match rng.f64() {
                u if u < share => Drawn::Discrete(0),
                u if u < 0.5 => Drawn::Discrete(1),
                _ => Drawn::Point(-1.0 + 4.0 * rng.f64().sqrt()),
            },
            |x| 0.5 * (x + 1.0) / 8.0,
        )
    };
    run(0.3).assert(0.01, 1, "mixture");
    assert!(run(0.31).check(0.01, 1).is_err());
    let indices =
        ChiSquare::new(100_000).indices(&[0.5, 0.25, 0.25], |rng| Some((rng.u32() % 4).saturating_sub(1) as usize));
    indices.assert(0.01, 1, "indices");
    let never = ChiSquare::new(100_000).indices(&[0.5, 0.5, 0.0], |rng| Some((rng.u32() % 100 % 3) as usize));
    assert!(never.check(0.01, 1).is_err());
}

#[test]
fn samples_at_zero_density_fail() {
    let outcome = ChiSquare::new(100_000).square(
        |rng| Some(if rng.f64() < 2e-4 { [0.9, 0.9] } else { [0.5 * rng.f64(), rng.f64()] }),
        |[x, _]| if x < 0.5 { 2.0 } else { 0.0 },
    );
    assert!(outcome.check(0.01, 100).unwrap_err().contains("density is zero"));
    let nan = ChiSquare::new(1000).square(|rng| Some([rng.f64(), rng.f64()]), |_| f64::NAN);
    assert!(nan.check(0.01, 1).is_err());
}

#[test]
fn jumps_of_the_density_are_integrated() {
    let ring = |[x, y]: [f64; 2]| if (0.04..0.25).contains(&(x * x + y * y)) { 1.0 / (0.21 * PI) } else { 0.0 };
    let sample = |rng: &mut Rng| {
        let (r, phi) = ((0.04 + 0.21 * rng.f64()).sqrt(), TAU * rng.f64());
        Some([r * phi.cos(), r * phi.sin()])
    };
    ChiSquare::new(200_000).rectangle([-1.0, 1.0], [-1.0, 1.0], sample, ring).assert(0.01, 1, "ring");
}

#[test]
fn p_values_are_uniform() {
    let p_values: Vec<f64> = (0..300)
        .map(|seed| {
            let (sample, pdf) = lobe(5.0, 1.0);
            ChiSquare::new(10_000).cells(50).seed(1000 + seed).sphere(sample, pdf).p_value
        })
        .collect();
    assert!(kolmogorov_uniform(&p_values) > 0.01, "{}", kolmogorov_uniform(&p_values));
    // And not so when the density is a little off.
    let p_values: Vec<f64> = (0..50)
        .map(|seed| {
            let (sample, pdf) = (lobe(5.0, 1.0).0, lobe(5.2, 1.0).1);
            ChiSquare::new(10_000).cells(50).seed(1000 + seed).sphere(sample, pdf).p_value
        })
        .collect();
    assert!(kolmogorov_uniform(&p_values) < 0.01);
}

#[test]
fn quadrature_is_public() {
    assert!((integrate_1d(|x| 1.0 / x, [1.0, 2.0], 1, 1e-12) - 2.0f64.ln()).abs() < 1e-12);
}
