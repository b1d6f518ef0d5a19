//! Seconds and errors of simplification.
//!
//! `simplify_speed [POSITIONS FACES] TARGET [OUT]`: raw little-endian f32 and u32 triples, or without them a bumpy sphere; with
//! OUT, the result as `OUT.positions` and `OUT.faces`; with `--measure N`, the distance from N points each way.

use std::ops::ControlFlow;

use etendue_simplify::{MeshRef, Options, Placement, Target, distance, simplify};

fn main() {
    let mut args: Vec<String> = std::env::args().skip(1).collect();
    let mut flag = |name: &str| {
        let found = args.iter().position(|arg| arg == name);
        found.map(|i| args.remove(i)).is_some()
    };
    let fast = flag("--fast");
    let no_polish = flag("--no-polish");
    let keep_topology = flag("--keep-topology");
    let runs = if flag("--once") { 1 } else { 3 };
    let mut value = |name: &str| {
        let found = args.iter().position(|arg| arg == name)?;
        args.remove(found);
        Some(args.remove(found))
    };
    let sigma = value("--sigma").map(|v| v.parse().expect("a number"));
    let samples: Option<usize> = value("--measure").map(|v| v.parse().expect("a number"));
    let method = value("--method");
    let placement = value("--placement");
    let read = |path: &str| std::fs::read(path).expect("a file");
    let (positions, faces) = if args.len() >= 3 {
        let word = |bytes: &[u8]| [bytes[0], bytes[1], bytes[2], bytes[3]];
        let positions =
            read(&args[0]).chunks_exact(12).map(|p| [0, 4, 8].map(|i| f32::from_le_bytes(word(&p[i..])))).collect();
        let faces =
            read(&args[1]).chunks_exact(12).map(|p| [0, 4, 8].map(|i| u32::from_le_bytes(word(&p[i..])))).collect();
        args.drain(..2);
        (positions, faces)
    } else {
        bumpy_sphere(400)
    };
    let target = args[0].parse().expect("a number of faces");
    let mesh =
        MeshRef { positions: &positions, faces: &faces, normals: None, uvs: None, colors: None, materials: None };
    let mut options = Options::new(Target::Faces(target));
    options.fast = fast;
    options.polish = !no_polish;
    options.keep_topology = keep_topology;
    if let Some(sigma) = sigma {
        options.placement = Placement::Probabilistic { sigma };
    }
    match placement.as_deref() {
        Some("endpoint") => options.placement = Placement::Endpoint,
        Some("perturbed") => options.placement = Placement::Perturbed,
        Some("midpoint") => options.placement = Placement::Midpoint,
        _ => {}
    }
    match method.as_deref() {
        Some("quadric-union") => options.method = etendue_simplify::Method::QuadricUnion,
        Some("shortest-edge") => options.method = etendue_simplify::Method::ShortestEdge,
        _ => {}
    }
    let mut seconds = Vec::new();
    let mut result = None;
    for _ in 0..runs {
        let start = std::time::Instant::now();
        result = Some(simplify(&mesh, &options, &mut |_| ControlFlow::Continue(())).expect("a valid mesh"));
        seconds.push(start.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    let result = result.expect("a result");
    println!("{:?}", result.report);
    println!("seconds {:.4} (least {:.4})", seconds[runs / 2], seconds[0]);
    if let Some(samples) = samples {
        let found = distance(&mesh, &result.mesh.as_ref(), samples, 0, &mut |_| ControlFlow::Continue(()));
        let found = found.expect("surfaces");
        let [rms, largest] = [found.rms(), found.largest()].map(|x| 1e4 * x / found.diagonal);
        println!("in 1e-4 of the diagonal: rms {rms:.4}, largest {largest:.3}");
        println!("farthest from the original {:?}, from the result {:?}", found.forth.farthest, found.back.farthest);
    }
    if let Some(out) = args.get(1) {
        let bytes: Vec<u8> = result.mesh.positions.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(format!("{out}.positions"), bytes).expect("written");
        let bytes: Vec<u8> = result.mesh.faces.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(format!("{out}.faces"), bytes).expect("written");
    }
}

/// A latitude-longitude sphere with bumps.
fn bumpy_sphere(n: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut positions = vec![[0.0, 0.0, 1.0]];
    for i in 1..n {
        for j in 0..2 * n {
            let theta = std::f64::consts::PI * f64::from(i) / f64::from(n);
            let phi = std::f64::consts::PI * f64::from(j) / f64::from(n);
            let r = 1.0 + 0.05 * libm::sin(9.0 * theta) * libm::sin(7.0 * phi) * libm::sin(theta);
            let s = r * libm::sin(theta);
            positions.push([s * libm::cos(phi), s * libm::sin(phi), r * libm::cos(theta)].map(|v| v as f32));
        }
    }
    positions.push([0.0, 0.0, -1.0]);
    let last = positions.len() as u32 - 1;
    let at = |i: u32, j: u32| 1 + (i - 1) * 2 * n + j % (2 * n);
    let mut faces = Vec::new();
    for j in 0..2 * n {
        faces.push([0, at(1, j), at(1, j + 1)]);
        faces.push([last, at(n - 1, j + 1), at(n - 1, j)]);
        for i in 1..n - 1 {
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    (positions, faces)
}
