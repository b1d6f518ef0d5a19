//! Grids of density: what they are at a point, and what keeps them honest.

use crate::flights::{Case, lumpy, medium, stream, turned};
use etendue::{
    math::{DAffine3, DVec3, Vec3, dvec3, vec3},
    medium::{Density, DensityGrid, GridError, Medium, Segment, Voxels},
    spectrum::Spectrum,
};
use etendue_testkit::Rng;
use std::{sync::Arc, time::Instant};

fn grid(size: [u32; 3], values: Vec<f32>) -> Arc<DensityGrid> {
    Arc::new(DensityGrid::new(size, Voxels::F32(values)).unwrap())
}

fn placed(grid: Arc<DensityGrid>, to_world: DAffine3) -> Density {
    Density::new(grid, to_world, 1.0).unwrap()
}

#[test]
fn densities_are_trilinear_and_nothing_is_outside() {
    // 0, 1, .. along x, 10 times that along y, 100 times along z.
    let values = (0..24u16).map(|i| f32::from(i % 4 + 10 * (i / 4 % 3) + 100 * (i / 12)));
    let grid = grid([4, 3, 2], values.collect());
    assert_eq!((grid.range(), grid.size(), grid.repaired()), ([0.0, 123.0], [4, 3, 2], 0));
    assert_eq!(grid.mean(), 61.5);
    // A voxel is a metre; the box starts at (5, 0, -1).
    let to_world = DAffine3::from_translation(dvec3(5.0, 0.0, -1.0)) * DAffine3::from_scale(dvec3(4.0, 3.0, 2.0));
    let density = placed(grid, to_world);
    for (point, expected) in [
        (vec3(5.5, 0.5, -0.5), 0.0),
        (vec3(8.5, 2.5, 0.5), 123.0),
        (vec3(7.0, 1.5, 0.0), 61.5),
        (vec3(5.75, 0.5, -0.5), 0.25),
        (vec3(5.0, 0.0, -1.0), 0.0),
        (vec3(9.0, 3.0, 1.0), 123.0),
        (vec3(5.2, 1.5, -0.9), 10.0),
        (vec3(9.001, 1.0, 0.0), 0.0),
        (vec3(6.0, -0.001, 0.0), 0.0),
        (vec3(6.0, 1.0, 1.001), 0.0),
        (vec3(f32::NAN, 1.0, 0.0), 0.0),
        (vec3(f32::INFINITY, 1.0, 0.0), 0.0),
    ] {
        assert!((density.at(point) - expected).abs() < 1e-4, "{point}: {}", density.at(point));
        let moved = density.relative_to(dvec3(100.0, -20.0, 3.0));
        let there = moved.at(point - vec3(100.0, -20.0, 3.0));
        assert!((there - expected).abs() < 2e-3 * (1.0 + expected), "{point}: {there}");
    }
}

#[test]
fn kinds_of_voxels_mean_the_same() {
    let full = [Voxels::U8(vec![0, 51, 255]), Voxels::U16(vec![0, 13107, 65535]), Voxels::F16(vec![0, 0x3266, 0x3c00])];
    for voxels in full {
        let bytes = voxels.bytes();
        let grid = DensityGrid::new([3, 1, 1], voxels).unwrap();
        let density = placed(Arc::new(grid), DAffine3::IDENTITY);
        assert_eq!(density.grid().bytes(), bytes + 8);
        for (x, expected) in [(1.0, 0.0), (3.0, 0.2), (4.0, 0.6), (5.0, 1.0)] {
            assert!((density.at(vec3(x / 6.0, 0.5, 0.5)) - expected).abs() < 1e-4);
        }
    }
}

/// A constant grid is the homogeneous medium that it looks like.
#[test]
fn a_constant_grid_is_homogeneous() {
    let plain = medium([0.1, 0.0, 0.3], [0.4, 1.5, 0.0], [1.0, 0.0, 0.2]);
    let half = Medium {
        absorption: plain.absorption * 2.0,
        scattering: plain.scattering * 2.0,
        emission: plain.emission * 2.0,
        ..plain.clone()
    };
    for size in [[1, 1, 1], [3, 20, 70]] {
        let count = size.iter().product::<u32>() as usize;
        let whole = DAffine3::from_translation(DVec3::splat(-10.0)) * DAffine3::from_scale(DVec3::splat(20.0));
        let varied = Medium { density: Some(placed(grid(size, vec![0.5; count]), whole)), ..half.clone() };
        let mut rng = Rng::new(1);
        for i in 0..500 {
            let direction = Vec3::from(rng.direction().map(|x| x as f32)).normalize();
            let segment = Segment { origin: vec3(0.1, -1.0, 2.0), direction, length: rng.f32() * 5.0 };
            let throughput = Spectrum([rng.f32(), rng.f32(), 0.2]);
            let t = segment.length * rng.f32();
            let densities = [&plain, &varied].map(|m| m.flight_density(&segment, throughput, t));
            assert!((densities[0] - densities[1]).abs() <= 1e-4 * densities[0], "{densities:?}");
            let scattering = [&plain, &varied].map(|m| m.scattering_at(segment.origin).0);
            assert_eq!(scattering[0], scattering[1]);
            let flight = varied.sample_flight(&segment, throughput, rng.f32(), &mut stream(i));
            // The sum of what is carried does not grow.
            let carried = throughput * flight.weight;
            assert!(carried.mean() <= throughput.mean() * 1.0001, "{flight:?}");
        }
    }
}

/// The stand-in for the density of flights is 0 where no flight ends, and near the truth elsewhere.
#[test]
fn the_stand_in_is_of_the_right_size() {
    let to_world = turned(DVec3::ZERO, dvec3(3.0, 4.0, 5.0));
    let varied = Medium { density: Some(placed(lumpy([17, 9, 5]), to_world)), ..medium([0.1; 3], [0.9; 3], [0.0; 3]) };
    let segment = Segment { origin: vec3(-3.0, 0.1, 0.2), direction: Vec3::X, length: 6.0 };
    let (mut sum, steps) = (0.0, 2000);
    for i in 0..steps {
        let t = 6.0 * (i as f32 + 0.5) / steps as f32;
        let stand_in = varied.flight_density(&segment, Spectrum::ONE, t);
        let here = varied.density.as_ref().unwrap().at(segment.origin + segment.direction * t);
        assert_eq!(stand_in > 0.0, here > 0.0, "{t}");
        sum += stand_in * 6.0 / steps as f32;
    }
    let passed = (0..4000).map(|i| varied.transmittance(&segment, &mut stream(i)).mean()).sum::<f32>() / 4000.0;
    assert!((sum + passed - 1.0).abs() < 0.15, "{sum} {passed}");
}

/// Grids that would need more collisions than there are grains of sand end in time, with finite numbers.
#[test]
fn hostile_grids_end() {
    let mut rng = Rng::new(2);
    let values: Vec<f32> = (0..30 * 30 * 30).map(|i| if i % 7 == 0 { 1e15 } else { rng.f32() * 1e-6 }).collect();
    let spikes = grid([30, 30, 30], values);
    let start = Instant::now();
    for coefficient in [1e-3, 1.0, 1e15] {
        for (absorption, scattering) in [([coefficient; 3], [0.0; 3]), ([0.0; 3], [coefficient, 0.0, 1.0])] {
            let density = placed(spikes.clone(), turned(DVec3::ZERO, DVec3::splat(3.0)));
            let medium = Medium { density: Some(density), ..medium(absorption, scattering, [1.0; 3]) };
            assert_eq!(medium.validate(), Ok(()));
            for i in 0..300 {
                let origin = Vec3::from([0; 3].map(|_| rng.range(-2.0, 2.0) as f32));
                let direction = Vec3::from(rng.direction().map(|x| x as f32)).normalize();
                let segment = Segment { origin, direction, length: f32::INFINITY };
                let flight = medium.sample_flight(&segment, Spectrum::ONE, rng.f32(), &mut stream(i));
                assert!(flight.weight.is_finite() && flight.density >= 0.0 && !flight.emitted.0[0].is_nan());
                let passed = medium.transmittance(&segment, &mut stream(i));
                assert!(passed.0.iter().all(|t| (0.0..=20.1).contains(t)), "{passed:?}");
            }
        }
    }
    assert!(start.elapsed().as_secs() < 20);
}

/// The same numbers for the same stream: a flight is a pure function of its arguments.
#[test]
fn flights_repeat() {
    let to_world = turned(DVec3::ZERO, dvec3(3.0, 4.0, 5.0));
    let medium = Medium { density: Some(placed(lumpy([17, 9, 5]), to_world)), ..medium([0.1; 3], [0.9; 3], [0.1; 3]) };
    let segment = Segment { origin: vec3(-3.0, 0.1, 0.2), direction: Vec3::X, length: 6.0 };
    let case = Case { name: String::new(), medium, segment, throughput: Spectrum::ONE };
    for i in 0..100 {
        let draw = || case.medium.sample_flight(&case.segment, case.throughput, 0.3, &mut stream(i));
        assert_eq!(draw(), draw());
    }
    assert_ne!(
        case.medium.transmittance(&case.segment, &mut stream(1)),
        case.medium.transmittance(&case.segment, &mut stream(2))
    );
}

/// From one voxel to 512^3 (by `ETENDUE_PROVE`: 128 MiB of bytes): memory is the voxels and little more.
#[test]
fn sizes_and_their_memory() {
    let prove = std::env::var("ETENDUE_PROVE").is_ok_and(|v| v == "1");
    for n in [1u32, 2, 17, 128, 512] {
        if n == 512 && !prove {
            continue;
        }
        let voxels = (0..n.pow(3)).map(|i| (i % 251) as u8).collect();
        let grid = Arc::new(DensityGrid::new([n; 3], Voxels::U8(voxels)).unwrap());
        assert!(grid.bytes() < n.pow(3) as usize * 102 / 100 + 40_000, "{n}: {}", grid.bytes());
        let medium = Medium {
            density: Some(placed(grid, DAffine3::from_scale(DVec3::splat(2.0)))),
            ..medium([0.0; 3], [0.5; 3], [0.0; 3])
        };
        let segment = Segment { origin: vec3(-1.0, 0.7, 0.9), direction: Vec3::X, length: 4.0 };
        let passed = (0..2000).map(|i| medium.transmittance(&segment, &mut stream(i)).0[0]).sum::<f32>() / 2000.0;
        let at = |x: f32| medium.density.as_ref().unwrap().at(vec3(x, 0.7, 0.9));
        let column = (0..20_000).map(|i| at((i as f32 + 0.5) * 1e-4)).sum::<f32>() * 1e-4;
        assert!((passed - (-0.5 * column).exp()).abs() < 0.04, "{n}: {passed} {column}");
    }
}

#[test]
fn what_is_no_grid_is_refused() {
    let new = |size, count| DensityGrid::new(size, Voxels::U8(vec![0; count])).map(|_| ());
    assert_eq!(new([0, 1, 1], 0), Err(GridError::Size([0, 1, 1])));
    assert_eq!(new([16385, 1, 1], 16385), Err(GridError::Size([16385, 1, 1])));
    assert_eq!(new([2, 3, 4], 23), Err(GridError::Count { size: [2, 3, 4], count: 23 }));
    assert_eq!(new([2, 3, 4], 24), Ok(()));
    let values = vec![f32::NAN, -1.0, f32::INFINITY, 2.0, f32::NEG_INFINITY, -0.0];
    let repaired = grid([6, 1, 1], values);
    assert_eq!((repaired.repaired(), repaired.range(), repaired.mean()), (4, [0.0, 2.0], 2.0 / 6.0));
    let flat = DAffine3::from_scale(dvec3(1.0, 0.0, 1.0));
    for wrong in
        [flat, DAffine3::from_translation(dvec3(f64::NAN, 0.0, 0.0)), DAffine3::from_scale(DVec3::splat(1e-320))]
    {
        assert_eq!(Density::new(repaired.clone(), wrong, 1.0), Err(GridError::Transform));
    }
    for wrong in [-1.0, f32::NAN, f32::INFINITY, 1e38] {
        assert!(matches!(Density::new(repaired.clone(), DAffine3::IDENTITY, wrong), Err(GridError::Scale(_))));
    }
}

#[test]
fn coefficients_are_checked() {
    let good = medium([0.0, 1.0, 1e15], [1e-30; 3], [1e30; 3]);
    assert_eq!(good.validate(), Ok(()));
    for wrong in [-1e-9, f32::NAN, f32::INFINITY, 2e15] {
        let cases = [
            ("absorption", Medium { absorption: Spectrum([0.0, wrong, 0.0]), ..good.clone() }),
            ("scattering", Medium { scattering: Spectrum([0.0, 0.0, wrong]), ..good.clone() }),
            ("emission", Medium { emission: Spectrum([wrong * 1e20, 0.0, 0.0]), ..good.clone() }),
        ];
        for (parameter, medium) in cases {
            assert_eq!(medium.validate().unwrap_err().parameter(), parameter);
        }
    }
    assert!(medium([1.0, 0.0, 1.0], [0.0; 3], [0.0, 1.0, 0.0]).glows_without_bound());
    assert!(!medium([1.0, 0.0, 1.0], [0.0; 3], [1.0, 0.0, 1.0]).glows_without_bound());
    assert!(Medium::default().is_vacuum() && !good.is_vacuum());
    let empty = placed(grid([2, 1, 1], vec![0.0, 0.0]), DAffine3::IDENTITY);
    assert!(Medium { density: Some(empty), ..good }.is_vacuum());
}

/// Through nothing, through very much, very far: numbers stay numbers.
#[test]
fn extremes_stay_finite() {
    let mut rng = Rng::new(9);
    let coefficients = [0.0, 1e-45, 1e-30, 1e-6, 1.0, 1e6, 1e15];
    let lengths = [0.0, 1e-30, 1e-3, 1.0, 1e15, f32::MAX, f32::INFINITY];
    let throughputs = [[1.0; 3], [0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1e-38], [1e30, 1e-30, 1.0], [f32::INFINITY; 3]];
    let mut pick = |from: &[f32]| from[rng.u32() as usize % from.len()];
    for i in 0..200_000 {
        let mut three = || [pick(&coefficients), pick(&coefficients), pick(&coefficients)];
        let medium = medium(three(), three(), [0.0; 3]);
        let segment = Segment { origin: Vec3::ZERO, direction: Vec3::X, length: pick(&lengths) };
        let throughput = Spectrum(throughputs[i as usize % throughputs.len()]);
        let u = pick(&[0.0, 1e-9, 0.3, 0.999_999_94]);
        let flight = medium.sample_flight(&segment, throughput, u, &mut stream(i));
        let what = || format!("{medium:?} {segment:?} {throughput:?} {u}: {flight:?}");
        assert!(flight.weight.is_finite() && flight.density.is_finite() && flight.density >= 0.0, "{}", what());
        assert!(flight.distance.is_none_or(|t| t < segment.length), "{}", what());
        let carried = throughput * flight.weight;
        assert!(!throughput.is_finite() || carried.mean() <= 1.001 * throughput.mean(), "{}", what());
        let passed = medium.transmittance(&segment, &mut stream(i));
        assert!(passed.0.iter().all(|t| (0.0..=1.0).contains(t)));
    }
    let glow = |k: f32, length: f32| {
        let segment = Segment { origin: Vec3::ZERO, direction: Vec3::X, length };
        medium([k; 3], [0.0; 3], [2.0; 3]).sample_flight(&segment, Spectrum::ONE, 0.5, &mut stream(0)).emitted.0[0]
    };
    for (k, length) in [(1e-6, 0.5f32), (1e-3, 0.1), (0.2, 1e-3), (3.0, 2.0), (1e6, 10.0)] {
        let (wide_k, wide_length) = (f64::from(k), f64::from(length));
        let exact = -2.0 * (-wide_k * wide_length).exp_m1() / wide_k;
        assert!((f64::from(glow(k, length)) / exact - 1.0).abs() < 1e-6, "{k} {length}");
    }
    assert_eq!((glow(0.0, 3.0), glow(4.0, f32::INFINITY), glow(0.0, f32::INFINITY)), (6.0, 0.5, f32::INFINITY));
}
