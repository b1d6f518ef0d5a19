//! Times the choice among lamps: `cargo run --release -p etendue --example light_tree`.
//!
//! Small triangles fill a cube; points inside choose among them and ask for the probability of what they chose.

use etendue::{
    light::{Light, LightContext, LightTable, TriangleLight},
    math::Vec3,
    spectrum::Spectrum,
};
use std::time::Instant;

/// Numbers in [0, 1) that depend on their count alone.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn point(&mut self) -> Vec3 {
        Vec3::new(self.next() as f32, self.next() as f32, self.next() as f32) * 10.0
    }
}

fn main() {
    const CHOICES: u32 = 200_000;
    println!("{:>9}  {:>10}  {:>12}  {:>14}", "lamps", "build, s", "choice, ns", "probability, ns");
    for count in [2, 10, 100, 10_000, 1_000_000] {
        let mut numbers = Numbers(1);
        let lights = (0..count).map(|_| {
            let at = numbers.point();
            let vertices = [(); 3].map(|()| at + numbers.point() * 0.01);
            Light::Triangle(TriangleLight { vertices, radiance: Spectrum::ONE, two_sided: false })
        });
        let lights: Vec<Light> = lights.collect();
        let clock = Instant::now();
        let Ok(table) = LightTable::new(lights, 10.0) else { return };
        let build = clock.elapsed().as_secs_f64();
        let contexts: Vec<(LightContext, f64)> = (0..CHOICES)
            .map(|_| {
                let normal = (numbers.point() - Vec3::splat(5.0)).normalize();
                (LightContext { point: numbers.point(), normal, transmits: false, time: 0.0 }, numbers.next())
            })
            .collect();
        let clock = Instant::now();
        let chosen: Vec<_> = contexts.iter().map(|(ctx, u)| table.select(ctx, *u)).collect();
        let choice = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let pairs = contexts.iter().zip(&chosen);
        let sum: f64 = pairs.flat_map(|((ctx, _), c)| c.map(|c| f64::from(table.probability(ctx, c.index)))).sum();
        let probability = clock.elapsed().as_secs_f64();
        let nanoseconds = 1e9 / f64::from(CHOICES);
        println!("{count:>9}  {build:>10.3}  {:>12.0}  {:>14.0}", choice * nanoseconds, probability * nanoseconds);
        assert!(sum > 0.0);
    }
}
