//! BSDFs in lanes scatter to the bit as alone, on every instruction set.
#![expect(clippy::needless_range_loop, reason = "an index is the lane, in several arrays at once")]

use crate::{
    cases::{cases, random_direction},
    robustness::{extreme_direction, extreme_material, extreme_number},
};
use etendue::{
    bsdf::{
        Bsdf, BsdfEval, Density,
        lanes::{InLanes, LANES, LaneBsdf, LaneSample, MOST_NUMBERS, Numbers},
    },
    material::Material,
    math::{Vec3, vec3},
};
use etendue_accel::{Isa, Kernel, run};
use etendue_testkit::Rng;
use std::{array, marker::PhantomData};

type Vectors = [Numbers; 3];

/// Of a vertex: value and density of an evaluation; direction, weight, density, eta, and whether it is discrete,
/// transmitted and valid, of a sample.
type Scattered = [f32; 15];

/// Vertices of one kind of BSDF.
struct Vertices {
    bsdf: [Numbers; MOST_NUMBERS],
    wo: Vectors,
    wi: Vectors,
    random: Vectors,
}

struct Scatter<'a, B> {
    vertices: &'a Vertices,
    scattered: &'a mut [Numbers; 15],
    kind: PhantomData<B>,
}

#[inline(always)]
fn vector(of: &Vectors, i: usize) -> Vec3 {
    vec3(of[0][i], of[1][i], of[2][i])
}

#[inline(always)]
fn flag(is: bool) -> f32 {
    if is { 1.0 } else { 0.0 }
}

impl<B: LaneBsdf> Kernel for Scatter<'_, B> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { vertices, scattered: to, .. } = self;
        for i in 0..LANES {
            let bsdf = B::load(&vertices.bsdf, i);
            let BsdfEval { value, pdf } = bsdf.eval(vector(&vertices.wo, i), vector(&vertices.wi, i));
            [to[0][i], to[1][i], to[2][i]] = value.0;
            to[3][i] = pdf;
        }
        for i in 0..LANES {
            let bsdf = B::load(&vertices.bsdf, i);
            let u = vector(&vertices.random, i);
            let sample = bsdf.sample(vector(&vertices.wo, i), u.x, [u.y, u.z]);
            let LaneSample { wi, weight, density, is_discrete, transmitted, eta, is_valid } = sample;
            [to[4][i], to[5][i], to[6][i]] = wi.to_array();
            [to[7][i], to[8][i], to[9][i]] = weight.0;
            [to[10][i], to[11][i]] = [density, eta];
            [to[12][i], to[13][i], to[14][i]] = [flag(is_discrete), flag(transmitted), flag(is_valid)];
        }
    }
}

fn scattered_alone(bsdf: &Bsdf, wo: Vec3, wi: Vec3, u: Vec3) -> Scattered {
    let BsdfEval { value, pdf } = bsdf.eval(wo, wi);
    let mut all = [0.0; 15];
    all[..3].copy_from_slice(&value.0);
    all[3] = pdf;
    if let Some(sample) = bsdf.sample(wo, u.x, [u.y, u.z]) {
        all[4..7].copy_from_slice(&sample.wi.to_array());
        all[7..10].copy_from_slice(&sample.weight.0);
        all[10..12].copy_from_slice(&[sample.density.value(), sample.eta]);
        let is_discrete = matches!(sample.density, Density::Discrete(_));
        all[12..].copy_from_slice(&[flag(is_discrete), flag(sample.transmitted), 1.0]);
    }
    all
}

/// A vertex: how it scatters, `wo`, `wi` and random numbers.
type Vertex = (Bsdf, [Vec3; 3]);

fn compare<B: LaneBsdf>(batch: &[Vertex], in_lanes: impl Fn(&Bsdf) -> B) {
    const { assert!(B::NUMBERS <= MOST_NUMBERS) };
    let empty = [0.0; LANES];
    let mut vertices = Vertices { bsdf: [empty; MOST_NUMBERS], wo: [empty; 3], wi: [empty; 3], random: [empty; 3] };
    for (i, (bsdf, vectors)) in batch.iter().enumerate() {
        in_lanes(bsdf).store(&mut vertices.bsdf, i);
        for axis in 0..3 {
            [vertices.wo[axis][i], vertices.wi[axis][i], vertices.random[axis][i]] = vectors.map(|v| v[axis]);
        }
        assert_eq!((B::IS_DELTA, B::TRANSMITS), (bsdf.is_delta(), bsdf.transmits()), "{bsdf:?}");
    }
    for isa in Isa::available() {
        let mut found = [empty; 15];
        run(isa, Scatter::<B> { vertices: &vertices, scattered: &mut found, kind: PhantomData });
        for (i, (bsdf, [wo, wi, u])) in batch.iter().enumerate() {
            let alone = scattered_alone(bsdf, *wo, *wi, *u);
            let mut lane: Scattered = array::from_fn(|number| found[number][i]);
            if lane[14] == 0.0 {
                lane[4..].fill(0.0);
            }
            assert_eq!(
                lane.map(f32::to_bits),
                alone.map(f32::to_bits),
                "{isa}, {bsdf:?}: {wo} {wi} {u}: {lane:?} {alone:?}"
            );
        }
    }
}

/// Collects vertices by kind. The match has no wildcard: a new kind does not compile until it is listed here.
macro_rules! kinds {
    ($($kind:ident),* $(,)?) => {
        const KINDS: [&str; [$(stringify!($kind)),*].len()] = [$(stringify!($kind)),*];

        fn kind(bsdf: &Bsdf) -> Option<&'static str> {
            Some(match bsdf.in_lanes()? {
                $(InLanes::$kind(_) => stringify!($kind),)*
            })
        }

        fn compare_kind(kind: &str, batch: &[Vertex]) {
            match kind {
                $(stringify!($kind) => compare(batch, |bsdf| match bsdf.in_lanes() {
                    Some(InLanes::$kind(b)) => b,
                    other => panic!("{other:?} among {kind}"),
                }),)*
                _ => panic!("{kind}"),
            }
        }
    };
}
kinds!(Lambert, Diffuse, Mirror, Glass, RoughMetal, RoughGlass, Mtl, Phong, PhongBothSides);

/// Compares the vertices of each kind, as many as fit into the lanes at a time.
#[derive(Default)]
struct Batches {
    waiting: [Vec<Vertex>; KINDS.len()],
    compared: [usize; KINDS.len()],
}

impl Batches {
    fn add(&mut self, bsdf: Bsdf, rng: &mut Rng) {
        let Some(kind) = kind(&bsdf) else { return };
        let at = KINDS.iter().position(|name| *name == kind).unwrap();
        let random = vec3(extreme_number(rng), extreme_number(rng), extreme_number(rng));
        let mut direction = || if rng.f32() < 0.5 { extreme_direction(rng) } else { random_direction(rng) };
        self.waiting[at].push((bsdf, [direction(), direction(), random]));
        if self.waiting[at].len() == LANES {
            compare_kind(kind, &self.waiting[at]);
            self.waiting[at].clear();
            self.compared[at] += LANES;
        }
    }
}

#[test]
fn lanes_scatter_as_lone_vertices_do() {
    let (mut rng, mut batches) = (Rng::new(31), Batches::default());
    for case in cases() {
        for _ in 0..1500 {
            batches.add(case.bsdf, &mut rng);
        }
    }
    for _ in 0..200_000 {
        let scattering = extreme_material(&mut rng);
        let material: Material = Material::new("", scattering);
        if material.validate().is_ok() {
            batches.add(scattering.bsdf(), &mut rng);
        }
    }
    for (kind, compared) in KINDS.iter().zip(batches.compared) {
        assert!(compared >= 3000, "{kind}: {compared}");
    }
}
