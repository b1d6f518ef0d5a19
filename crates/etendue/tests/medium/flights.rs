//! Flights, transmittance and emission against quadrature, for every kind of medium.

use etendue::{
    math::{DAffine3, DQuat, DVec3, Vec3, dvec3, vec3},
    medium::{Density, DensityGrid, Medium, Segment, Voxels},
    sampling::{SampleKey, Sampler, Slot, Stream},
    spectrum::Spectrum,
};
use etendue_testkit::{
    Moments, Rng,
    chi2::{ChiSquare, Drawn},
    sidak,
    ttest::t_test,
};
use std::sync::Arc;

pub fn stream(seed: u32) -> Stream {
    Sampler::Independent.stream(SampleKey { stream: 7, index: seed, cell: 0 }, 1, Slot::FreeFlight)
}

/// A medium on a segment with a path's throughput.
pub struct Case {
    pub name: String,
    pub medium: Medium,
    pub segment: Segment,
    pub throughput: Spectrum,
}

pub fn medium(absorption: [f32; 3], scattering: [f32; 3], emission: [f32; 3]) -> Medium {
    let [absorption, scattering, emission] = [absorption, scattering, emission].map(Spectrum);
    Medium { absorption, scattering, emission, ..Medium::default() }
}

/// Half of the voxels hold something, from very little to much.
pub fn lumpy(size: [u32; 3]) -> Arc<DensityGrid> {
    let mut rng = Rng::new(4);
    let count = size.iter().product::<u32>();
    let values = (0..count).map(|_| if rng.f32() < 0.5 { 0.0 } else { rng.f32().powi(3) * 2.0 });
    Arc::new(DensityGrid::new(size, Voxels::F32(values.collect())).unwrap())
}

/// A turned box about a point.
pub fn turned(center: DVec3, size: DVec3) -> DAffine3 {
    let turn = DQuat::from_axis_angle(dvec3(1.0, 2.0, -0.5).normalize(), 0.7);
    DAffine3::from_scale_rotation_translation(size, turn, center) * DAffine3::from_translation(DVec3::splat(-0.5))
}

fn cases() -> Vec<Case> {
    let segment = |origin: Vec3, target: Vec3| {
        let way = target - origin;
        Segment { origin, direction: way.normalize(), length: way.length() }
    };
    let through = segment(vec3(-3.0, 0.1, 0.2), vec3(3.0, -0.3, 0.1));
    let grey = medium([0.25; 3], [0.5; 3], [0.5; 3]);
    let coloured = medium([0.1, 0.0, 0.3], [0.4, 1.5, 0.0], [1.0, 0.0, 0.2]);
    let fire = medium([0.0; 3], [0.0; 3], [3.0, 1.0, 0.1]);
    let partly = medium([0.0, 0.8, 0.0], [0.0, 0.2, 0.5], [0.1, 0.2, 0.3]);
    let white = Spectrum::ONE;
    let tinted = Spectrum([1.0, 0.05, 0.3]);
    let red = Spectrum([0.7, 0.0, 0.0]);
    let mut cases = Vec::new();
    let mut add = |name: &str, medium: &Medium, segment, throughput| {
        let (name, medium) = (name.to_owned(), medium.clone());
        cases.push(Case { name, medium, segment, throughput });
    };
    for (name, medium) in [("grey", &grey), ("coloured", &coloured), ("fire", &fire), ("partly", &partly)] {
        add(name, medium, through, white);
        add(&format!("{name}, tinted path"), medium, through, tinted);
        let place = |grid: &Arc<DensityGrid>, scale| {
            let to_world = turned(dvec3(10.2, 0.0, -4.9), dvec3(3.0, 4.0, 5.0));
            let density = Density::new(grid.clone(), to_world, scale).unwrap();
            let medium = Medium { density: Some(density), ..medium.clone() };
            medium.relative_to(dvec3(10.0, 0.0, -5.0))
        };
        let grid = lumpy([17, 9, 5]);
        add(&format!("{name} grid"), &place(&grid, 1.0), through, tinted);
        // Computed from voxel to voxel.
        add(&format!("{name}, dense grid"), &place(&grid, 40.0), through, tinted);
        add(&format!("{name}, dense in parts"), &place(&lumpy([40, 30, 30]), 9.0), through, white);
        let inside = segment(vec3(0.1, 0.2, -0.2), vec3(0.5, -0.8, 0.4));
        add(&format!("{name}, ends inside"), &place(&grid, 3.0), inside, white);
    }
    add("coloured, path of one channel", &coloured, through, red);
    cases
}

/// Density along the segment, 1 where it does not vary.
fn density(case: &Case, t: f64) -> f64 {
    let segment = &case.segment;
    let point = segment.origin + segment.direction * t as f32;
    case.medium.density.as_ref().map_or(1.0, |density| f64::from(density.at(point)))
}

/// Tables of the density and the column from 0 at equal steps, and the step.
struct Reference {
    density: Vec<f64>,
    column: Vec<f64>,
    step: f64,
}

impl Reference {
    fn new(case: &Case) -> Self {
        let steps = 20_000;
        let step = f64::from(case.segment.length) / f64::from(steps);
        let at = |i: f64| density(case, i * step);
        let density: Vec<f64> = (0..=steps).map(|i| at(f64::from(i))).collect();
        let mut column = vec![0.0];
        for i in 0..steps {
            let middle = at(f64::from(i) + 0.5);
            let [low, high] = [density[i as usize], density[i as usize + 1]];
            column.push(column[i as usize] + step * (low + 4.0 * middle + high) / 6.0);
        }
        Self { density, column, step }
    }

    fn transmittance(&self, k: f32) -> f64 {
        (-f64::from(k) * self.column.last().unwrap()).exp()
    }

    /// `density * transmittance * f(t)` over the segment, by the trapezoidal rule.
    fn integral(&self, k: f32, f: impl Fn(f64) -> f64) -> f64 {
        let value = |i: usize| self.density[i] * (-f64::from(k) * self.column[i]).exp() * f(i as f64 * self.step);
        (1..self.density.len()).map(|i| 0.5 * self.step * (value(i - 1) + value(i))).sum()
    }

    /// The column at a distance.
    fn column_at(&self, t: f64) -> f64 {
        let x = (t / self.step).clamp(0.0, (self.column.len() - 1) as f64);
        let i = (x as usize).min(self.column.len() - 2);
        self.column[i] + (x - i as f64) * (self.column[i + 1] - self.column[i])
    }
}

fn samples() -> u32 {
    if std::env::var("ETENDUE_PROVE").is_ok_and(|v| v == "1") { 1_000_000 } else { 40_000 }
}

/// Weights of flights that pass sum to the transmittance, those of flights that end to the scattered light, wherever that is
/// looked at; ratio tracking gives the transmittance; emission is what quadrature finds.
#[test]
fn flights_are_unbiased() {
    let cases = cases();
    let level = sidak(0.01, cases.len() * 3 * 5);
    for (number, case) in cases.iter().enumerate() {
        let reference = Reference::new(case);
        let extinction = case.medium.extinction();
        let mut rng = Rng::new(number as u64);
        let mut found = [[Moments::new(); 5]; 3];
        for i in 0..samples() {
            let mut stream = stream(i);
            let flight = case.medium.sample_flight(&case.segment, case.throughput, rng.f32(), &mut stream);
            assert!(flight.weight.is_finite() && flight.emitted.is_finite(), "{}: {flight:?}", case.name);
            assert!(flight.distance.is_none_or(|t| t >= 0.0 && t <= case.segment.length), "{}", case.name);
            let passed = case.medium.transmittance(&case.segment, &mut stream);
            for (channel, found) in found.iter_mut().enumerate() {
                let weight = f64::from(flight.weight.0[channel]);
                let ended = |f: f64| if flight.distance.is_some() { weight * f } else { 0.0 };
                let t = f64::from(flight.distance.unwrap_or(0.0));
                found[0].push(if flight.distance.is_none() { weight } else { 0.0 });
                found[1].push(ended(1.0));
                found[2].push(ended(t));
                found[3].push(f64::from(passed.0[channel]));
                found[4].push(f64::from(flight.emitted.0[channel]));
            }
        }
        for (channel, found) in found.iter().enumerate() {
            let k = extinction.0[channel];
            let scattering = f64::from(case.medium.scattering.0[channel]);
            let emission = f64::from(case.medium.emission.0[channel]);
            // What nothing is carried of is not followed.
            let carried = f64::from(u8::from(case.throughput.0[channel] > 0.0));
            let expected = [
                carried * reference.transmittance(k),
                carried * scattering * reference.integral(k, |_| 1.0),
                carried * scattering * reference.integral(k, |t| t),
                reference.transmittance(k),
                emission * reference.integral(k, |_| 1.0),
            ];
            for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
                let what = format!("{}: quantity {i} of channel {channel}", case.name);
                let off = (found.mean() - expected).abs();
                // Rounding, and the quadrature of kinks.
                if off > 2e-5 * (1.0 + expected) {
                    t_test(found, expected).assert(level, &what);
                }
            }
        }
    }
}

/// Distances are distributed as the mean of the channels says, each channel with the share of the throughput; for what
/// does not vary that is the stated density.
#[test]
fn distances_follow_their_density() {
    let cases = cases();
    for (number, case) in cases.iter().enumerate().filter(|(_, case)| !case.medium.extinction().is_black()) {
        let reference = Reference::new(case);
        let total: f32 = case.throughput.0.iter().sum();
        let extinction = case.medium.extinction();
        let density = |t: f64| {
            let of = |c: usize| {
                let (share, k) = (f64::from(case.throughput.0[c] / total), f64::from(extinction.0[c]));
                share * k * density(case, t) * (-k * reference.column_at(t)).exp()
            };
            of(0) + of(1) + of(2)
        };
        let mut number_of = 0;
        let sample = |rng: &mut Rng| {
            number_of += 1;
            let mut stream = stream(number_of);
            let flight = case.medium.sample_flight(&case.segment, case.throughput, rng.f32(), &mut stream);
            match flight.distance {
                Some(t) => {
                    let stated = case.medium.flight_density(&case.segment, case.throughput, t);
                    assert_eq!(stated, flight.density, "{}", case.name);
                    if case.medium.density.is_none() {
                        assert!((f64::from(stated) / density(f64::from(t)) - 1.0).abs() < 1e-4, "{}", case.name);
                    }
                    Drawn::Point(f64::from(t))
                }
                None => Drawn::Nothing,
            }
        };
        let range = [0.0, f64::from(case.segment.length)];
        ChiSquare::new(u64::from(samples())).cells(100).seed(number as u64).interval(range, sample, density).assert(
            0.01,
            cases.len(),
            &case.name,
        );
    }
}
