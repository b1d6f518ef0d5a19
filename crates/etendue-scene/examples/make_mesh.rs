//! Makes scenes/knot.ply: a closed tube along a trefoil knot, 5,280 quadrilaterals with smooth normals, binary PLY.
//!
//!     cargo run -p etendue-scene --example make_mesh -- scenes/knot.ply

use glam::DVec3;
use std::{fmt::Write as _, io::Write as _, path::PathBuf, process::ExitCode};

/// Rings along the knot, corners of a ring, and the tube's radius; the knot's middle line runs on a torus of radii 2 and 1.
const RINGS: u32 = 240;
const CORNERS: u32 = 22;
const TUBE: f64 = 0.42;

/// The middle line at `turn` in [0, 1], and the middle of the torus's tube there.
fn middle_line(turn: f64) -> (DVec3, DVec3) {
    let angle = std::f64::consts::TAU * turn;
    let ((sin2, cos2), (sin3, cos3)) = (libm::sincos(2.0 * angle), libm::sincos(3.0 * angle));
    let ring = DVec3::new(cos2, sin2, 0.0);
    (ring * (2.0 + cos3) - DVec3::Z * sin3, ring * 2.0)
}

/// Positions and unit normals, ring after ring.
fn vertices() -> Vec<(DVec3, DVec3)> {
    let mut vertices = Vec::new();
    for ring in 0..RINGS {
        let turn = f64::from(ring) / f64::from(RINGS);
        let (point, centre) = middle_line(turn);
        let tangent = (middle_line(turn + 1e-5).0 - middle_line(turn - 1e-5).0).normalize();
        let outward = (point - centre).reject_from(tangent).normalize();
        let across = tangent.cross(outward);
        for corner in 0..CORNERS {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(corner) / f64::from(CORNERS));
            let normal = outward * cos + across * sin;
            vertices.push((point + normal * TUBE, normal));
        }
    }
    vertices
}

/// The file.
pub fn knot() -> Vec<u8> {
    let vertices = vertices();
    let mut header = String::from("ply\nformat binary_little_endian 1.0\ncomment Etendue, examples/make_mesh.rs\n");
    let faces = RINGS * CORNERS;
    let _ = writeln!(header, "element vertex {}", vertices.len());
    for property in ["x", "y", "z", "nx", "ny", "nz"] {
        let _ = writeln!(header, "property float {property}");
    }
    let _ = writeln!(header, "element face {faces}\nproperty list uchar ushort vertex_indices\nend_header");
    let mut bytes = header.into_bytes();
    for (position, normal) in vertices {
        for x in position.as_vec3().to_array().into_iter().chain(normal.as_vec3().to_array()) {
            bytes.extend(x.to_le_bytes());
        }
    }
    for ring in 0..RINGS {
        for corner in 0..CORNERS {
            let at = |ring: u32, corner: u32| ((ring % RINGS) * CORNERS + corner % CORNERS) as u16;
            bytes.push(4);
            for index in [at(ring, corner), at(ring + 1, corner), at(ring + 1, corner + 1), at(ring, corner + 1)] {
                bytes.extend(index.to_le_bytes());
            }
        }
    }
    bytes
}

#[allow(dead_code)]
fn main() -> ExitCode {
    let Some(path) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("usage: make_mesh FILE.ply");
        return ExitCode::from(1);
    };
    match std::fs::File::create(&path).and_then(|mut file| file.write_all(&knot())) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cannot write {}: {error}", path.display());
            ExitCode::from(4)
        }
    }
}
