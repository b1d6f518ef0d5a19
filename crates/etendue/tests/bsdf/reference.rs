//! Values against independent f64 formulas, written as the papers have them.

use crate::cases::{direction, draw, random_direction};
use etendue::{
    bsdf::{Bsdf, Density, fresnel, ggx, ggx::Ggx},
    material::Scattering,
    math::Vec3,
    spectrum::Spectrum,
};
use etendue_testkit::{Moments, Rng, integrate_2d, ttest};
use std::f64::consts::PI;

fn rough_glass(ior: f32, alpha: f32) -> Bsdf {
    Scattering::RoughGlass { ior, alpha, reflection_tint: Spectrum::ONE, transmission_tint: Spectrum::ONE }.bsdf()
}

/// Fresnel's amplitude formulas in the angles.
fn dielectric(cos_i: f64, eta: f64) -> f64 {
    let sin_t2 = (1.0 - cos_i * cos_i) / (eta * eta);
    if sin_t2 >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin_t2).sqrt();
    let s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    let p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    0.5 * (s * s + p * p)
}

type Complex = (f64, f64);

fn mul(a: Complex, b: Complex) -> Complex {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

fn div_norm2(a: Complex, b: Complex) -> f64 {
    (a.0 * a.0 + a.1 * a.1) / (b.0 * b.0 + b.1 * b.1)
}

/// The same formulas with a complex index: r_s = (c - n c_t) / (c + n c_t), r_p = (n c - c_t) / (n c + c_t).
fn conductor(cos_i: f64, eta: f64, k: f64) -> f64 {
    let n = (eta, k);
    let n2 = mul(n, n);
    let w = (n2.0 - (1.0 - cos_i * cos_i), n2.1);
    // Principal square root of n^2 - sin^2 = (n c_t)^2.
    let modulus = w.0.hypot(w.1).sqrt();
    let half = 0.5 * w.1.atan2(w.0);
    let n_ct = (modulus * half.cos(), modulus * half.sin());
    let s = div_norm2((cos_i - n_ct.0, -n_ct.1), (cos_i + n_ct.0, n_ct.1));
    // r_p times n on both sides: n^2 c and n c_t.
    let n2c = (n2.0 * cos_i, n2.1 * cos_i);
    let p = div_norm2((n2c.0 - n_ct.0, n2c.1 - n_ct.1), (n2c.0 + n_ct.0, n2c.1 + n_ct.1));
    0.5 * (s + p)
}

#[test]
fn fresnel_of_dielectrics() {
    for eta in [1.5, 1.0 / 1.5, 1.000_01, 0.999, 2.4, 1.0, 40.0] {
        for i in 0..=2000 {
            let cos = (f64::from(i) / 2000.0).powi(3) as f32;
            let ours = fresnel::dielectric(cos, eta as f32);
            let reference = dielectric(f64::from(cos), f64::from(eta as f32));
            // Near the critical angle the reflectance has infinite slope.
            let critical = 1.0 - (1.0 - f64::from(cos).powi(2)) / (eta * eta);
            let tolerance = if critical.abs() < 1e-4 { 0.05 } else { 1e-5 };
            let expected = match (cos, eta) {
                (0.0, _) => 1.0,
                (_, 1.0) => 0.0,
                _ => reference,
            };
            assert!((f64::from(ours.reflectance) - expected).abs() < tolerance, "{eta} {cos}: {ours:?} {expected}");
        }
    }
    // Normal incidence ((n - 1) / (n + 1))^2, Brewster's angle tan = n (only s is reflected), total reflection.
    assert!((fresnel::dielectric(1.0, 1.5).reflectance - 0.04).abs() < 1e-7);
    let brewster = 1.0f64 / (1.0 + 1.5f64 * 1.5).sqrt();
    let s = (1.0 - 2.25) / (1.0 + 2.25f64);
    assert!((f64::from(fresnel::dielectric(brewster as f32, 1.5).reflectance) - 0.5 * s * s).abs() < 1e-6);
    assert_eq!(fresnel::dielectric(0.7, 1.0 / 1.5).reflectance, 1.0);
    assert!(fresnel::dielectric(0.76, 1.0 / 1.5).reflectance < 1.0);
}

#[test]
fn fresnel_of_conductors() {
    for (eta, k) in
        [(0.05f32, 4.4f32), (0.16, 3.6), (1.4, 1.9), (3.0, 3.3), (1.5, 0.0), (0.0, 2.0), (0.5, 0.01), (500.0, 900.0)]
    {
        for i in 0..=2000 {
            let cos = (f64::from(i) / 2000.0).powi(3) as f32;
            let ours = f64::from(fresnel::conductor(cos, Spectrum::splat(eta), Spectrum::splat(k))[1]);
            let reference = conductor(f64::from(cos), f64::from(eta), f64::from(k));
            assert!((ours - reference).abs() < 3e-6, "{eta} {k} {cos}: {ours} {reference}");
        }
    }
}

/// GGX as Walter et al. have it, equations 33 and 34.
fn d(alpha: f64, m: [f64; 3]) -> f64 {
    let cos2 = m[2] * m[2];
    let tan2 = (m[0] * m[0] + m[1] * m[1]) / cos2;
    alpha * alpha / (PI * cos2 * cos2 * (alpha * alpha + tan2).powi(2))
}

fn lambda(alpha: f64, w: [f64; 3]) -> f64 {
    let tan2 = (w[0] * w[0] + w[1] * w[1]) / (w[2] * w[2]);
    0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0)
}

pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

/// Equation 20 of Walter et al. with height-correlated masking and shadowing, cosine included.
pub fn reflection(alpha: f64, wo: [f64; 3], wi: [f64; 3], fresnel: impl Fn(f64) -> f64) -> f64 {
    let m = unit([0, 1, 2].map(|c| wo[c] + wi[c]));
    let g = 1.0 / (1.0 + lambda(alpha, wo) + lambda(alpha, wi));
    fresnel(dot(wo, m)) * g * d(alpha, m) / (4.0 * wo[2])
}

/// Equation 21, for light that arrives from `wi` in a medium of index `n_i` and leaves along `wo` in one of `n_o`:
/// there i is our wi, o our wo. Cosine included.
fn refraction(alpha: f64, wo: [f64; 3], n_o: f64, wi: [f64; 3], n_i: f64) -> f64 {
    let m = unit([0, 1, 2].map(|c| -(n_i * wi[c] + n_o * wo[c])));
    let m = if m[2] < 0.0 { m.map(|x| -x) } else { m };
    let (o_m, i_m) = (dot(wo, m), dot(wi, m));
    if o_m * wo[2] <= 0.0 || i_m * wi[2] <= 0.0 {
        return 0.0;
    }
    let g = 1.0 / ((1.0 + lambda(alpha, wo)) * (1.0 + lambda(alpha, wi)));
    let transmitted = 1.0 - dielectric(o_m.abs(), n_i / n_o);
    let f = (i_m * o_m / (wi[2] * wo[2])).abs() * n_o * n_o * transmitted * g * d(alpha, m)
        / (n_i * i_m + n_o * o_m).powi(2);
    f * wi[2].abs()
}

pub fn f64s(v: Vec3) -> [f64; 3] {
    // Unit to f64 precision, so that the reference does not see the rounding of the input.
    unit(v.to_array().map(f64::from))
}

#[test]
fn rough_metal_is_the_papers_formula() {
    let (eta, k) = (Spectrum([0.2, 1.0, 1.5]), Spectrum([3.5, 2.5, 1.9]));
    for alpha in [0.02f32, 0.2, 0.7, 1.0] {
        let metal = Scattering::RoughMetal { eta, k, alpha: [alpha; 2], tint: Spectrum([1.0, 0.5, 0.25]) }.bsdf();
        let mut rng = Rng::new(15);
        for i in 0..4000 {
            let wo = random_direction(&mut rng);
            let mut wi =
                if i % 2 == 0 { random_direction(&mut rng) } else { draw(&metal, wo, &mut rng).map_or(wo, |s| s.wi) };
            wi.z = wi.z.copysign(wo.z);
            let value = metal.eval(wo, wi).value;
            let up = |v: Vec3| f64s(Vec3::new(v.x, v.y, v.z.abs()));
            for c in 0..3 {
                let tint = [1.0, 0.5, 0.25][c];
                let reference = tint
                    * reflection(f64::from(alpha), up(wo), up(wi), |cos| {
                        conductor(cos, f64::from(eta[c]), f64::from(k[c]))
                    });
                let ours = f64::from(value[c]);
                assert!((ours - reference).abs() < 2e-3 * reference + 1e-9, "{alpha} {wo} {wi}: {ours} {reference}");
            }
        }
    }
}

#[test]
fn rough_glass_is_the_papers_formula() {
    for (ior, alpha) in [(1.5f32, 0.05f32), (1.5, 0.5), (0.7, 0.3), (1.2, 1.0)] {
        let glass = rough_glass(ior, alpha);
        let mut rng = Rng::new(16);
        let mut refracted = 0;
        for i in 0..4000 {
            let wo = random_direction(&mut rng);
            let wi =
                if i % 2 == 0 { random_direction(&mut rng) } else { draw(&glass, wo, &mut rng).map_or(wo, |s| s.wi) };
            let side = 1.0f32.copysign(wo.z);
            let [n_o, n_i] = [wo, wi].map(|w| if w.z > 0.0 { 1.0 } else { f64::from(ior) });
            let [o, i] = [wo, wi].map(|w| f64s(Vec3::new(w.x, w.y, w.z * side)));
            let (reference, eta) = if i[2] > 0.0 {
                let eta = if wo.z > 0.0 { f64::from(ior) } else { 1.0 / f64::from(ior) };
                (reflection(f64::from(alpha), o, i, |cos| dielectric(cos, eta)), eta)
            } else {
                refracted += 1;
                (refraction(f64::from(alpha), o, n_o, i, n_i), n_i / n_o)
            };
            let ours = f64::from(glass.eval(wo, wi).value[0]);
            let tolerance = 5e-3 * reference + 1e-6;
            assert!((ours - reference).abs() < tolerance, "{eta} {alpha} {wo} {wi}: {ours} {reference}");
        }
        assert!(refracted > 1000);
    }
}

/// Kd cos / pi + Ks D G2 / (4 z_o), and for the discrete lobes the shares that Ks (a mirror) and Tf (an interface) have.
#[test]
fn mtl_is_the_sum_of_its_lobes() {
    let (kd, ks, tf) = ([0.3, 0.2, 0.1], [0.1, 0.3, 0.6], [0.2, 0.4, 0.1]);
    let mtl = |alpha| {
        Scattering::Mtl { diffuse: Spectrum(kd), specular: Spectrum(ks), alpha, transmission: Spectrum(tf), ior: 1.5 }
            .bsdf()
    };
    let (glossy, polished) = (mtl(0.3), mtl(0.0));
    let mut rng = Rng::new(18);
    for _ in 0..4000 {
        let wo = random_direction(&mut rng);
        let mut wi = random_direction(&mut rng);
        wi.z = wi.z.copysign(wo.z);
        let up = |v: Vec3| f64s(Vec3::new(v.x, v.y, v.z.abs()));
        let facets = reflection(f64::from(0.3f32), up(wo), up(wi), |_| 1.0);
        for (bsdf, specular) in [(&glossy, facets), (&polished, 0.0)] {
            let value = bsdf.eval(wo, wi).value;
            for c in 0..3 {
                let reference = f64::from(kd[c] * wi.z.abs()) / PI + f64::from(ks[c]) * specular;
                assert!((f64::from(value[c]) - reference).abs() < 1e-3 * reference + 1e-6, "{value:?} {reference}");
            }
        }
        let eta = if wo.z > 0.0 { 1.5 } else { 1.0 / 1.5 };
        let reflected = dielectric(f64::from(wo.z.abs()), eta);
        for (bsdf, mirror) in [(&glossy, 0.0), (&polished, 1.0)] {
            let Some(sample) = draw(bsdf, wo, &mut rng) else { continue };
            let Density::Discrete(probability) = sample.density else { continue };
            for c in 0..3 {
                let share = f64::from(sample.weight[c] * probability * sample.eta * sample.eta);
                let interface = f64::from(tf[c]);
                let reference = if sample.transmitted {
                    interface * (1.0 - reflected)
                } else {
                    mirror * f64::from(ks[c]) + interface * reflected
                };
                assert!((share - reference).abs() < 1e-3, "{wo} {sample:?} {reference}");
            }
        }
    }
}

/// The facets' projected area is that of the surface, and the visible ones' that seen from `wo`, also if anisotropic.
#[test]
fn facets_cover_the_surface() {
    for (alpha_x, alpha_y) in [(0.2, 0.2), (1.0, 1.0), (0.1, 0.5), (0.9, 0.3)] {
        let ggx = Ggx::new(alpha_x, alpha_y).unwrap();
        for wo in [direction(0.0, 0.0, 1.0), direction(50.0, 30.0, 1.0), direction(85.0, 100.0, 1.0)] {
            let over_normals = |f: &dyn Fn(Vec3) -> f64| {
                integrate_2d(
                    |[theta, phi]| {
                        let m = direction(theta.to_degrees(), phi.to_degrees(), 1.0);
                        f(m) * f64::from(ggx.density(m)) * theta.sin()
                    },
                    [0.0, 0.0],
                    [0.5 * PI, 2.0 * PI],
                    16,
                    1e-4,
                )
            };
            assert!((over_normals(&|m| f64::from(m.z)) - 1.0).abs() < 1e-3);
            let visible = over_normals(&|m| f64::from(wo.dot(m).max(0.0) * ggx.masking_over_cos(wo)));
            assert!((visible - 1.0).abs() < 1e-3, "{alpha_x} {alpha_y} {wo}: {visible}");
        }
    }
}

/// Anisotropic normals are drawn in proportion to their visible area.
#[test]
fn visible_normals_follow_their_density() {
    let ggx = Ggx::new(0.15, 0.6).unwrap();
    for (i, wo) in
        [direction(0.0, 0.0, 1.0), direction(60.0, 40.0, 1.0), direction(86.0, 200.0, 1.0)].into_iter().enumerate()
    {
        etendue_testkit::chi2::ChiSquare::new(100_000)
            .seed(i as u64)
            .sphere(
                |rng: &mut Rng| Some(ggx.sample_visible(wo, rng.f32x2()).to_array().map(f64::from)),
                |m: [f64; 3]| {
                    let m = Vec3::from_array(m.map(|x| x as f32));
                    if m.z < 0.0 {
                        0.0
                    } else {
                        f64::from(ggx.density(m) * wo.dot(m).max(0.0) * ggx.masking_over_cos(wo))
                    }
                },
            )
            .assert(0.01, 3, &format!("normals from {wo}"));
    }
}

/// Rough surfaces tend to the smooth ones: shares and directions.
#[test]
fn small_widths_tend_to_specular() {
    let alpha = 1.5 * ggx::ALPHA_MIN;
    let (eta, k) = (Spectrum::splat(0.2), Spectrum::splat(3.5));
    let metal = Scattering::RoughMetal { eta, k, alpha: [alpha; 2], tint: Spectrum::ONE }.bsdf();
    let glass = rough_glass(1.5, alpha);
    for (theta, side) in [(10.0, 1.0), (60.0, 1.0), (75.0, 1.0), (20.0, -1.0), (60.0, -1.0)] {
        let wo = direction(theta, 77.0, side);
        let mut rng = Rng::new(17);
        let eta_glass = if side > 0.0 { 1.5 } else { 1.0 / 1.5 };
        let expected = dielectric(f64::from(wo.z.abs()), eta_glass);
        let (mut from_metal, mut reflected, mut transmitted) = (Moments::new(), Moments::new(), Moments::new());
        for _ in 0..20_000 {
            let sample = draw(&metal, wo, &mut rng);
            from_metal.push(sample.map_or(0.0, |s| f64::from(s.weight[0])));
            let sample = draw(&glass, wo, &mut rng).unwrap();
            assert!(matches!(sample.density, Density::SolidAngle(_)));
            let scaled = f64::from(sample.weight[0] * sample.eta * sample.eta);
            reflected.push(if sample.transmitted { 0.0 } else { scaled });
            transmitted.push(if sample.transmitted { scaled } else { 0.0 });
        }
        assert!((from_metal.mean() - conductor(f64::from(wo.z.abs()), 0.2, 3.5)).abs() < 1e-3);
        for (moments, expected) in [(reflected, expected), (transmitted, 1.0 - expected)] {
            let test = ttest::z_test(moments.mean(), moments.standard_error() + 2e-4, expected);
            test.assert(0.001, &format!("{theta} degrees, side {side}"));
        }
    }
}
