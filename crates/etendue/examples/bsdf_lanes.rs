//! How long scattering takes a vertex, alone and in lanes: `cargo run --release --example bsdf_lanes`.
//!
//! For each kind of BSDF that goes in lanes, nanoseconds of an evaluation and of a sample: alone, and among 64 vertices in a loop
//! compiled for the instruction set. Arguments: `portable`, `avx2` or `avx512` for the instruction set.
#![expect(clippy::needless_range_loop, reason = "an index is the lane, in several arrays at once")]

use etendue::{
    bsdf::{
        Bsdf,
        lanes::{InLanes, LANES, LaneBsdf, MOST_NUMBERS, Numbers},
        metals,
    },
    bsdf::{BsdfEval, PhongLobes},
    material::Scattering,
    math::{Vec3, vec3},
    sampling::warp,
    spectrum::Spectrum,
};
use etendue_accel::{Isa, Kernel, run};
use std::{hint::black_box, time::Instant};

type Vectors = [Numbers; 3];

/// Directions and random numbers of some vertices, and the numbers of their BSDFs.
struct Vertices {
    bsdf: [Numbers; MOST_NUMBERS],
    wo: Vectors,
    wi: Vectors,
    random: Vectors,
}

#[derive(Clone, Copy)]
struct Results([Numbers; 7]);

struct Eval<'a, B>(&'a Vertices, &'a mut Results, B);
struct Sample<'a, B>(&'a Vertices, &'a mut Results, B);

#[inline(always)]
fn vector(of: &Vectors, i: usize) -> Vec3 {
    vec3(of[0][i], of[1][i], of[2][i])
}

impl<B: LaneBsdf> Kernel for Eval<'_, B> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self(vertices, Results(to), _) = self;
        for i in 0..LANES {
            let bsdf = B::load(&vertices.bsdf, i);
            let BsdfEval { value, pdf } = bsdf.eval(vector(&vertices.wo, i), vector(&vertices.wi, i));
            [to[0][i], to[1][i], to[2][i]] = value.0;
            to[3][i] = pdf;
        }
    }
}

impl<B: LaneBsdf> Kernel for Sample<'_, B> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self(vertices, Results(to), _) = self;
        for i in 0..LANES {
            let bsdf = B::load(&vertices.bsdf, i);
            let [lobe, u, v] = vector(&vertices.random, i).to_array();
            let sample = bsdf.sample(vector(&vertices.wo, i), lobe, [u, v]);
            [to[0][i], to[1][i], to[2][i]] = sample.wi.to_array();
            let weight = if sample.is_valid { sample.weight } else { Spectrum::BLACK };
            [to[3][i], to[4][i], to[5][i]] = weight.0;
            to[6][i] = sample.density * if sample.transmitted { sample.eta } else { 1.0 };
        }
    }
}

/// Nanoseconds that a vertex takes: the least of many short runs, so that other work on the machine is in few of them.
fn time(mut work: impl FnMut()) -> f64 {
    const ROUNDS: u32 = 20;
    let mut least = f64::INFINITY;
    for _ in 0..500 {
        let start = Instant::now();
        for _ in 0..ROUNDS {
            work();
        }
        least = least.min(start.elapsed().as_secs_f64());
    }
    least * 1e9 / f64::from(ROUNDS) / LANES as f64
}

fn measure<B: LaneBsdf>(name: &str, isa: Isa, bsdf: &Bsdf, lanes: B) {
    let mut state = 1u32;
    let mut random = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (((word >> 22) ^ word) >> 8) as f32 * (1.0 / 16_777_216.0)
    };
    let empty = [0.0; LANES];
    let mut vertices = Vertices { bsdf: [empty; MOST_NUMBERS], wo: [empty; 3], wi: [empty; 3], random: [empty; 3] };
    for i in 0..LANES {
        lanes.store(&mut vertices.bsdf, i);
        let (wo, wi) = (warp::uniform_sphere([random(), random()]), warp::uniform_sphere([random(), random()]));
        for axis in 0..3 {
            vertices.wo[axis][i] = wo[axis];
            vertices.wi[axis][i] = wi[axis];
            vertices.random[axis][i] = random();
        }
    }
    let alone = [*bsdf; LANES];
    let mut results = Results([empty; 7]);
    let eval_alone = time(|| {
        for (i, bsdf) in black_box(&alone).iter().enumerate() {
            black_box(bsdf.eval(vector(&vertices.wo, i), vector(&vertices.wi, i)));
        }
    });
    let sample_alone = time(|| {
        for (i, bsdf) in black_box(&alone).iter().enumerate() {
            let [lobe, u, v] = vector(&vertices.random, i).to_array();
            black_box(bsdf.sample(vector(&vertices.wo, i), lobe, [u, v]));
        }
    });
    let eval = time(|| run(isa, Eval(black_box(&vertices), black_box(&mut results), lanes)));
    let sample = time(|| run(isa, Sample(black_box(&vertices), black_box(&mut results), lanes)));
    println!(
        "{name:24} eval {eval_alone:6.1} alone {eval:5.1} in lanes ({:4.1}), sample {sample_alone:6.1} and {sample:5.1} ({:4.1})",
        eval_alone / eval,
        sample_alone / sample
    );
}

fn main() {
    let isa = std::env::args().find_map(|a| a.parse::<Isa>().ok()).unwrap_or(Isa::detect());
    println!("{isa}, nanoseconds a vertex");
    let (one, some, black) = (Spectrum::ONE, Spectrum([0.3, 0.2, 0.1]), Spectrum::BLACK);
    let gold = metals::METALS[1];
    let phong = PhongLobes {
        diffuse: some,
        specular: some,
        exponent: 30.0,
        diffuse_transmission: black,
        transmission: black,
        transmission_exponent: 1.0,
        ior: 1.5,
    };
    let frosted = PhongLobes { diffuse_transmission: some, transmission: some, transmission_exponent: 60.0, ..phong };
    let kinds = [
        ("diffuse", Scattering::Diffuse { reflectance: some, transmittance: black }),
        ("leaf", Scattering::Diffuse { reflectance: some, transmittance: some }),
        ("mirror", Scattering::Mirror { reflectance: some }),
        ("glass", Scattering::Glass { ior: 1.5, reflection_tint: one, transmission_tint: one, thin: false }),
        ("rough metal", Scattering::RoughMetal { eta: gold.eta, k: gold.k, alpha: [0.2; 2], tint: one }),
        ("rough glass", Scattering::RoughGlass { ior: 1.5, alpha: 0.2, reflection_tint: one, transmission_tint: one }),
        ("mtl", Scattering::Mtl { diffuse: some, specular: some, alpha: 0.2, transmission: black, ior: 1.0 }),
        ("phong", Scattering::Phong(phong)),
        ("phong, transmitting", Scattering::Phong(frosted)),
    ];
    for (name, scattering) in kinds {
        let bsdf = scattering.bsdf();
        match bsdf.in_lanes() {
            None => println!("{name:24} is not one of them"),
            Some(InLanes::Lambert(b)) => measure(name, isa, &bsdf, b),
            Some(InLanes::Diffuse(b)) => measure(name, isa, &bsdf, b),
            Some(InLanes::Mirror(b)) => measure(name, isa, &bsdf, b),
            Some(InLanes::Glass(b)) => measure(name, isa, &bsdf, b),
            Some(InLanes::RoughMetal(b)) => measure(name, isa, &bsdf, b),
            Some(InLanes::RoughGlass(b)) => measure(name, isa, &bsdf, b),
            Some(InLanes::Mtl(b)) => measure(name, isa, &bsdf, b),
            Some(InLanes::Phong(b)) => measure(name, isa, &bsdf, b),
            Some(InLanes::PhongBothSides(b)) => measure(name, isa, &bsdf, b),
        }
    }
}
