//! Ugly input through every option: nothing crashes, what was watertight stays so, and no fault is added.
//!
//! A fixed sample, and ten thousand meshes with `ETENDUE_PROVE=1`. Every mesh goes through methods, placements and switches in
//! combinations that change from mesh to mesh, so that all of them come equally often; the rest is drawn.
// What is made is measured, never compared bit by bit with another machine's.
#![allow(clippy::disallowed_methods)]

mod mesh;
mod rules;
#[path = "../shapes/mod.rs"]
mod shapes;

use std::panic::{AssertUnwindSafe, catch_unwind};

use etendue_simplify::{Keep, Method, Options, Placement, Target, simplify};
use etendue_testkit::Rng;
use mesh::{below, random_mesh};
use rayon::prelude::*;
use rules::Input;
use shapes::carry_on;

const METHODS: [Method; 3] = [Method::Quadric, Method::QuadricUnion, Method::ShortestEdge];
const PLACEMENTS: [Placement; 6] = [
    Placement::Auto,
    Placement::Probabilistic { sigma: 0.1 },
    Placement::Probabilistic { sigma: 0.0 },
    Placement::Perturbed,
    Placement::Endpoint,
    Placement::Midpoint,
];
/// Open edges, topology, fast.
const SWITCHES: usize = 3;
const COMBINATIONS: usize = (METHODS.len() * PLACEMENTS.len()) << SWITCHES;
/// Combinations that a mesh goes through, of a sample and of all.
const OF_A_MESH: [usize; 2] = [12, 36];
/// One mesh of so many is large enough to be worked on in blocks.
const LARGE: u64 = 250;
/// One run of so many has an error for its target, and one of so many is polished, which take much longer.
const ERRORS: usize = 600;
const POLISHED: usize = 10;

/// What is drawn, and what number `combination` of all combinations says.
fn options(rng: &mut Rng, input: &Input, combination: usize) -> Options {
    let faces = input.mesh.faces.len();
    let mut options = Options::new(match below(rng, 4) {
        _ if faces < 2000 && below(rng, ERRORS) == 0 => Target::Error(0.3 * rng.f64() * rng.f64()),
        0 => Target::Ratio(0.05 + 0.9 * rng.f64()),
        1 => Target::Faces(0),
        _ => Target::Faces(below(rng, faces.max(1))),
    });
    let mut rest = combination % COMBINATIONS;
    let mut next = |count: usize| {
        let digit = rest % count;
        rest /= count;
        digit
    };
    options.method = METHODS[next(METHODS.len())];
    options.placement = PLACEMENTS[next(PLACEMENTS.len())];
    options.keep_boundary = next(2) == 1;
    options.keep_topology = next(2) == 1;
    options.fast = next(2) == 1;
    options.polish = below(rng, POLISHED) == 0;
    options.seed = below(rng, 1000) as u64;
    options.crease_angle = [1f64, 20.0, 40.0, 90.0, 180.0][below(rng, 5)].to_radians();
    let [uvs, normals, colors, materials] = [0; 4].map(|_| rng.f64() < 0.8);
    options.keep = Keep { uvs, normals, colors, materials };
    if rng.f64() < 0.4 {
        options.locked = (0..below(rng, 8)).map(|_| below(rng, input.mesh.positions.len() + 3) as u32).collect();
    }
    options
}

/// What became of a mesh.
struct Tally {
    collapses: usize,
    cuts: usize,
    faults: Vec<String>,
}

fn all_of(seed: u64, runs: usize) -> Tally {
    let mut rng = Rng::new(seed);
    let large = seed % LARGE == LARGE - 1;
    let input = Input::new(random_mesh(&mut rng, large));
    let mut tally = Tally { collapses: 0, cuts: 0, faults: vec![] };
    let count = if large { runs / 6 } else { runs };
    for i in 0..count {
        // A step without a common divisor with the number of combinations passes all of them.
        let combination = (seed as usize * runs + i) * 37 % COMBINATIONS;
        let options = options(&mut rng, &input, combination);
        let run = || simplify(&input.mesh.as_ref(), &options, &mut carry_on);
        let fault = match catch_unwind(AssertUnwindSafe(run)) {
            Ok(Ok(result)) => {
                tally.collapses += result.report.collapses;
                tally.cuts += result.report.cuts;
                input.judge(&options, &result).err()
            }
            Ok(Err(error)) => Some(error.to_string()),
            Err(_) => Some("panic".to_owned()),
        };
        if let Some(fault) = fault {
            let faces = input.mesh.faces.len();
            tally.faults.push(format!("mesh {seed}, {faces} faces, run {i}: {fault}; {options:?}"));
        }
    }
    tally
}

#[test]
fn nothing_breaks() {
    let prove = std::env::var_os("ETENDUE_PROVE").is_some();
    let (count, runs) = if prove { (10_000, OF_A_MESH[1]) } else { (250, OF_A_MESH[0]) };
    let tallies: Vec<Tally> = (0..count).into_par_iter().map(|seed| all_of(seed, runs)).collect();
    let faults: Vec<&String> = tallies.iter().flat_map(|tally| &tally.faults).collect();
    for fault in faults.iter().take(40) {
        println!("{fault}");
    }
    let [collapses, cuts] =
        [|t: &Tally| t.collapses, |t: &Tally| t.cuts].map(|of| tallies.iter().map(of).sum::<usize>());
    println!("{count} meshes, {collapses} collapses, {cuts} cuts, {} faults", faults.len());
    assert!(faults.is_empty(), "{} faults", faults.len());
    assert!(collapses > 25 * runs * count as usize && cuts > 0, "{collapses} collapses and {cuts} cuts are no test");
}

#[test]
fn every_combination_comes() {
    let mut seen = [false; COMBINATIONS];
    (0..COMBINATIONS).for_each(|i| seen[i * 37 % COMBINATIONS] = true);
    assert!(seen.iter().all(|seen| *seen));
}
