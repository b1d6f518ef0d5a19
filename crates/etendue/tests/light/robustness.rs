//! Ugly input: whatever the light and the context, an answer is `None` or finite.

use super::{cases, double, samples};
use etendue::{
    light::{
        ConstantEnvironment, DirectionalLight, DiskLight, ImageEnvironment, Light, LightContext, PointLightSource,
        RadianceMap, RectangleLight, RoundOutline, SphereLight, SpotLight, SunSky, TriangleLight,
    },
    math::{DMat3, DVec3, Vec3},
    spectrum::Spectrum,
};
use etendue_testkit::Rng;
use std::sync::Arc;

const LAST: f32 = 1.0 - f32::EPSILON / 2.0;

fn one_in(n: u32, rng: &mut Rng) -> bool {
    rng.u32() % n == 1
}

fn ugly_number(rng: &mut Rng) -> f32 {
    const UGLY: [f32; 16] = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        1.000_000_1,
        0.5,
        1e-3,
        1e-20,
        -1e-38,
        1e-45,
        1e4,
        -1e12,
        1e30,
        f32::MAX,
        f32::INFINITY,
        f32::NAN,
    ];
    // Special values often, but mostly few in one test: all of them not finite would try nothing.
    match rng.u32() % 4 {
        0 => UGLY[rng.u32() as usize % UGLY.len()],
        1 => UGLY[rng.u32() as usize % 8],
        2 => rng.f32() * 2.0 - 1.0,
        _ => (rng.f32() * 2.0 - 1.0) * 10f32.powi((rng.u32() % 60) as i32 - 30),
    }
}

fn ugly_vector(rng: &mut Rng) -> Vec3 {
    Vec3::from_array([(); 3].map(|()| ugly_number(rng)))
}

fn ugly_light(rng: &mut Rng) -> Light {
    let radiance = Spectrum::ONE;
    let two_sided = one_in(2, rng);
    let [a, b, c, d] = [(); 4].map(|()| ugly_vector(rng));
    match rng.u32() % 10 {
        0 => Light::Triangle(TriangleLight { vertices: [a, b, c], radiance, two_sided }),
        1 => Light::Rectangle(RectangleLight { corner: a, u: b, v: c, radiance, two_sided }),
        2 => Light::Sphere(SphereLight { center: a, axes: [b, c, d], radiance, two_sided }),
        3 => Light::Point(PointLightSource { position: a, intensity: radiance }),
        4 => {
            let [cos_outer, cos_inner] = [ugly_number(rng), ugly_number(rng)];
            let axis = if one_in(2, rng) { b.normalize_or(Vec3::X) } else { b };
            Light::Spot(SpotLight { position: a, axis, cos_outer, cos_inner, intensity: radiance })
        }
        5 => {
            let direction = if one_in(2, rng) { a.normalize_or(Vec3::X) } else { a };
            Light::Directional(DirectionalLight { direction, irradiance: radiance })
        }
        6 => ugly_image(rng),
        7 => ugly_sun(rng),
        8 => ugly_disk(rng, two_sided),
        _ => Light::Environment(ConstantEnvironment { radiance }),
    }
}

/// A regular polygon, or what is left of one.
fn ugly_disk(rng: &mut Rng, two_sided: bool) -> Light {
    let normal = DVec3::from(rng.direction());
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    let (center, radius) = (ugly_vector(rng).as_dvec3(), f64::from(ugly_number(rng)));
    let count = 8 + rng.u32() % 60;
    let corner = |i: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(count)).sin_cos();
        center + (x * cos + y * sin) * radius
    };
    let rim: Vec<DVec3> = (0..count).map(corner).collect();
    match RoundOutline::new(&rim) {
        Some(outline) => Light::Disk(Arc::new(DiskLight { outline, radiance: Spectrum::ONE, two_sided })),
        None => Light::Environment(ConstantEnvironment { radiance: Spectrum::ONE }),
    }
}

fn ugly_image(rng: &mut Rng) -> Light {
    let (width, height) = (1 + rng.u32() % 4, 1 + rng.u32() % 4);
    let texels = (0..width * height).map(|_| [(); 3].map(|()| ugly_number(rng))).collect();
    let map = RadianceMap::new(width, height, texels).unwrap();
    let orientation =
        if one_in(2, rng) { DMat3::IDENTITY } else { DMat3::from_rotation_x(f64::from(ugly_number(rng))) };
    Light::Image(Arc::new(ImageEnvironment::new(Arc::new(map), orientation, Spectrum::ONE)))
}

fn ugly_sun(rng: &mut Rng) -> Light {
    let map = RadianceMap::new(1, 1, vec![[(); 3].map(|()| ugly_number(rng))]).unwrap();
    let sky = ImageEnvironment::new(Arc::new(map), DMat3::IDENTITY, Spectrum::ONE);
    let [to_sun, up] = [(); 2].map(|()| DVec3::from(rng.direction()));
    let irradiance = Spectrum([(); 3].map(|()| ugly_number(rng)));
    Light::SunSky(Arc::new(SunSky::new(sky, to_sun, up, rng.range(1e-4, 1.5), irradiance)))
}

fn ugly_context(rng: &mut Rng, light: &Light) -> LightContext {
    let on_light = match light {
        Light::Triangle(t) => [t.vertices[0], (t.vertices[0] + t.vertices[1]) * 0.5, t.vertices[2]],
        Light::Rectangle(r) => [r.corner, r.corner + r.u * 0.5 + r.v * 0.5, r.corner + r.v],
        Light::Disk(d) => {
            let (center, radius) = (d.outline.center(), d.outline.radius());
            let x = d.outline.normal().any_orthonormal_vector();
            [center, center + x * radius, center - x * (0.5 * radius)].map(|p| p.as_vec3())
        }
        Light::Sphere(s) => [s.center, s.center + s.axes[0], s.center - s.axes[1]],
        Light::Point(p) => [p.position; 3],
        Light::Spot(s) => [s.position; 3],
        Light::Directional(_) | Light::Environment(_) | Light::Image(_) | Light::SunSky(_) => [Vec3::ZERO; 3],
    };
    let point = match rng.u32() % 3 {
        0 => on_light[rng.u32() as usize % 3],
        1 => on_light[rng.u32() as usize % 3] + ugly_vector(rng) * 1e-6,
        _ => ugly_vector(rng),
    };
    let [x, y, z] = rng.direction();
    let normal = if one_in(3, rng) { Vec3::ZERO } else { Vec3::new(x as f32, y as f32, z as f32) };
    LightContext { point, normal, transmits: one_in(2, rng), time: 0.0 }
}

fn check(light: &Light, ctx: &LightContext, u: [f32; 2]) -> bool {
    let Some(sample) = light.sample(ctx, u) else { return false };
    let density = sample.density.value();
    let fine = density > 0.0
        && density.is_finite()
        && sample.radiance.is_finite()
        && (double(sample.wi).length() - 1.0).abs() < 1e-5
        && sample.target.is_none_or(|t| !t.is_nan());
    assert!(fine, "{light:?} from {ctx:?} at {u:?}: {sample:?}");
    true
}

#[test]
fn ugly_lights_and_contexts() {
    let mut rng = Rng::new(1);
    let mut drawn = 0;
    let n = samples(300_000, 20_000_000);
    for _ in 0..n {
        let light = ugly_light(&mut rng);
        let ctx = ugly_context(&mut rng, &light);
        let corner = |rng: &mut Rng| if one_in(2, rng) { 0.0 } else { LAST };
        let u = if one_in(4, &mut rng) { [corner(&mut rng), corner(&mut rng)] } else { rng.f32x2() };
        drawn += u64::from(check(&light, &ctx, u));
        let [x, y, z] = rng.direction();
        let pdf = light.pdf(&ctx, Vec3::new(x as f32, y as f32, z as f32), ugly_number(&mut rng).abs());
        assert!(pdf >= 0.0 && pdf.is_finite(), "{light:?} from {ctx:?}: density {pdf}");
        let power = light.power(ugly_number(&mut rng).into());
        assert!(power >= 0.0 && power.is_finite(), "{light:?}: power {power}");
    }
    assert!(drawn > n / 10, "only {drawn} samples in {n}: the test tries nothing");
}

/// On the light, in its plane, at its vertices: no light, and no density.
#[test]
fn contexts_on_the_light_gather_nothing() {
    for at in cases::placements() {
        for (name, light) in cases::flat(&at) {
            let (a, b, c) = match light {
                Light::Triangle(t) => (t.vertices[0], t.vertices[1], t.vertices[2]),
                Light::Rectangle(r) => (r.corner, r.corner + r.u, r.corner + r.v),
                Light::Disk(ref d) => {
                    let x = d.outline.normal().any_orthonormal_vector() * d.outline.radius();
                    let [a, b, c] = [DVec3::ZERO, x, d.outline.normal().cross(x)];
                    let at = |p: DVec3| (d.outline.center() + p).as_vec3();
                    (at(a), at(b), at(c))
                }
                _ => unreachable!("flat lights only"),
            };
            for point in [a, b, c, (a + b) * 0.5, (a + b + c) / 3.0, a + (a - b), b * 3.0 - c - a] {
                let ctx = LightContext { point, normal: Vec3::ZERO, transmits: true, time: 0.0 };
                let sample = light.sample(&ctx, [0.3, 0.6]);
                assert!(sample.is_none(), "{name} from {point}: {sample:?}");
                assert_eq!(light.pdf(&ctx, Vec3::Z, 1.0), 0.0, "{name} from {point}");
            }
        }
        for (name, light) in cases::round(&at) {
            let Light::Sphere(sphere) = light else { unreachable!("spheres only") };
            for axis in sphere.axes {
                let ctx = LightContext { point: sphere.center + axis, normal: Vec3::ZERO, transmits: true, time: 0.0 };
                let mut rng = Rng::new(6);
                let drawn = (0..2000).filter(|_| light.sample(&ctx, rng.f32x2()).is_some()).count();
                // From a point on it, a sphere that emits inward fills one half of all directions.
                let expected = if sphere.two_sided { 850..1150 } else { 0..1 };
                assert!(expected.contains(&drawn), "{name} from its surface: {drawn} of 2000");
            }
        }
    }
}
