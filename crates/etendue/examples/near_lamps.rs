//! Points on lamps near a table, one sample at each of many places: `cargo run --release -p etendue --example near_lamps`.
//!
//! The variance of what arrives on a diffuse surface, over its square, and the time of a sample; beside them those of places that
//! gather from both sides, where points go by solid angle without the cosine.

use etendue::{
    light::{DiskLight, Light, LightContext, LightTable, RectangleLight, RoundOutline, SphereLight, TriangleLight},
    math::{DVec3, Vec3, dvec3, vec3},
    sampling::{Sampler, Slot},
    spectrum::Spectrum,
};
use std::{sync::Arc, time::Instant};

const PLACES: u32 = 20_000;
const SAMPLES: u32 = 16;

/// Lamps over or beside the middle of a table 2 m wide.
fn lamps() -> Vec<(&'static str, Vec<Light>)> {
    let (radiance, two_sided) = (Spectrum::ONE, true);
    let rectangle = |corner, u, v| Light::Rectangle(RectangleLight { corner, u, v, radiance, two_sided });
    let triangle = |vertices| Light::Triangle(TriangleLight { vertices, radiance, two_sided });
    let ball = |center, radius| Light::Sphere(SphereLight::round(center, radius, radiance));
    let mut lamps = vec![
        ("rectangle overhead", rectangle(vec3(-0.8, 0.5, -0.4), Vec3::X * 1.6, Vec3::Z * 0.8)),
        ("panel on the floor", rectangle(vec3(-1.0, 0.0, -1.0), Vec3::X * 2.0, Vec3::Y * 1.5)),
        ("panel into the floor", rectangle(vec3(-1.0, -0.5, -1.0), Vec3::X * 2.0, Vec3::Y * 1.5)),
        ("parallelogram", rectangle(vec3(-0.8, 0.1, -0.8), vec3(1.6, 0.0, 0.2), vec3(0.5, 0.9, 0.0))),
        ("triangle", triangle([vec3(-0.8, 0.05, -1.0), vec3(0.8, 0.05, -1.0), vec3(0.2, 1.2, -1.2)])),
        ("ball overhead", ball(vec3(0.0, 0.6, 0.0), 0.3)),
        ("ball on the floor", ball(vec3(0.0, 0.3, 0.0), 0.3)),
        ("ball into the floor", ball(vec3(0.0, -0.1, 0.0), 0.3)),
        ("disk overhead", disk(OVERHEAD)),
        ("disk on its edge", disk(ON_EDGE)),
        ("disk into the floor", disk(INTO_FLOOR)),
    ];
    let mut lamps: Vec<_> = lamps.drain(..).map(|(name, light)| (name, vec![light])).collect();
    let cut =
        [("disk overhead, cut", OVERHEAD), ("disk on its edge, cut", ON_EDGE), ("disk in the floor, cut", INTO_FLOOR)];
    lamps.extend(cut.map(|(name, place)| (name, fan(place))));
    lamps
}

/// Middle, and half of two diameters at right angles.
type Disk = [DVec3; 3];
const OVERHEAD: Disk = [dvec3(0.0, 0.5, 0.0), dvec3(0.5, 0.0, 0.0), dvec3(0.0, 0.0, 0.5)];
const ON_EDGE: Disk = [dvec3(0.0, 0.5, 0.0), dvec3(0.4, 0.0, 0.3), dvec3(0.0, 0.5, 0.0)];
const INTO_FLOOR: Disk = [dvec3(0.0, 0.1, 0.0), dvec3(0.4, 0.0, 0.3), dvec3(0.0, 0.5, 0.0)];
const SIDES: u32 = 64;

fn rim([center, x, y]: Disk) -> Vec<DVec3> {
    let corner = |i: u32| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(i) / f64::from(SIDES));
        center + x * cos + y * sin
    };
    (0..SIDES).map(corner).collect()
}

fn disk(place: Disk) -> Light {
    let Some(outline) = RoundOutline::new(&rim(place)) else { unreachable!("it is round") };
    Light::Disk(Arc::new(DiskLight { outline, radiance: Spectrum::ONE, two_sided: true }))
}

/// The same as triangles, of which a tree of lights chooses.
fn fan(place: Disk) -> Vec<Light> {
    let rim = rim(place);
    let face = |i: usize| {
        let vertices = [place[0], rim[i], rim[(i + 1) % rim.len()]].map(|p| p.as_vec3());
        Light::Triangle(TriangleLight { vertices, radiance: Spectrum::ONE, two_sided: true })
    };
    (0..rim.len()).map(face).collect()
}

/// Mean over the places of the relative variance of the mean of all samples, and nanoseconds a sample.
fn measure(lights: &LightTable, transmits: bool) -> (f64, f64) {
    let clock = Instant::now();
    let (mut sum, mut places) = (0.0, 0);
    for place in 0..PLACES {
        let (mut mean, mut square) = (0.0f64, 0.0f64);
        let at = Sampler::Sobol.two_d(Sampler::Sobol.key(1, [0, 0], 2 * place), 0, Slot::Pixel);
        let point = vec3(2.0 * at[0] - 1.0, 0.0, 2.0 * at[1] - 1.0);
        let ctx = LightContext { point, normal: Vec3::Y, transmits, time: 0.0 };
        for sample in 0..SAMPLES {
            let key = Sampler::Independent.key(2, [place, 0], sample);
            let u = Sampler::Independent.two_d(key, 1, Slot::LightPosition);
            let select = f64::from(Sampler::Independent.two_d(key, 1, Slot::Pixel)[0]);
            let arrives =
                lights.sample(&ctx, select, u).map_or(0.0, |s| f64::from(s.wi.y.max(0.0) / s.density.value()));
            mean += arrives / f64::from(SAMPLES);
            square += arrives * arrives / f64::from(SAMPLES);
        }
        if mean > 0.0 {
            sum += (square - mean * mean) / (mean * mean);
            places += 1;
        }
    }
    let nanoseconds = 1e9 * clock.elapsed().as_secs_f64() / f64::from(PLACES * SAMPLES);
    (sum / f64::from(places.max(1)), nanoseconds)
}

fn main() {
    println!("{:<22}{:>12}{:>8}{:>14}{:>8}", "", "variance", "ns", "no cosine", "ns");
    for (name, lights) in lamps() {
        let light = match LightTable::new(lights, 1.0) {
            Ok(table) => table,
            Err(error) => panic!("{name}: {error}"),
        };
        let ((variance, time), (plain, plain_time)) = (measure(&light, false), measure(&light, true));
        println!("{name:<22}{variance:>12.4}{time:>8.0}{plain:>14.4}{plain_time:>8.0}");
    }
}
