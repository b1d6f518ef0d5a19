//! Closed solids with outward faces: strips drawn out in depth, and turned profiles. None shares a vertex with another.

use super::mesh::Mesh;
use glam::{DVec2, DVec3, dvec2, dvec3};
use std::f64::consts::PI;

impl Mesh {
    /// A box between two corners.
    pub fn block(&mut self, low: DVec3, high: DVec3) {
        let lower = [dvec2(low.x, low.z), dvec2(high.x, low.z)];
        let upper = [dvec2(low.x, high.z), dvec2(high.x, high.z)];
        self.strip(&lower, &upper, low.y, high.y);
    }

    /// The area between a lower and an upper line of as many points `(x, z)`, x growing, drawn out from y = `front` to `back`.
    pub fn strip(&mut self, lower: &[DVec2], upper: &[DVec2], front: f64, back: f64) {
        assert!(lower.len() == upper.len() && lower.len() > 1 && front < back, "a strip has two lines and some depth");
        let first = self.positions.len() as u32;
        for (l, u) in lower.iter().zip(upper) {
            assert!(l.y < u.y, "a strip is open at every point");
            self.positions.extend([
                dvec3(l.x, front, l.y),
                dvec3(u.x, front, u.y),
                dvec3(l.x, back, l.y),
                dvec3(u.x, back, u.y),
            ]);
        }
        // Corners of a cross section: 0 lower front, 1 upper front, 2 lower back, 3 upper back.
        let corner = |i: u32, c: u32| first + 4 * i + c;
        let last = lower.len() as u32 - 1;
        for i in 0..last {
            for (a, b) in [(0, 1), (1, 3), (3, 2), (2, 0)] {
                self.quad([corner(i, a), corner(i + 1, a), corner(i + 1, b), corner(i, b)]);
            }
        }
        self.quad([0, 1, 3, 2].map(|c| corner(0, c)));
        self.quad([0, 2, 3, 1].map(|c| corner(last, c)));
    }

    /// A profile of points (radius, z), z growing, turned about the vertical through `middle`; closed by flat ends.
    pub fn turned(&mut self, middle: DVec2, profile: &[DVec2], segments: u32) {
        let first = self.positions.len() as u32;
        for p in profile {
            for k in 0..segments {
                let (sin, cos) = libm::sincos(2.0 * PI * f64::from(k) / f64::from(segments));
                self.positions.push(dvec3(middle.x + p.x * cos, middle.y + p.x * sin, p.y));
            }
        }
        let last = profile.len() as u32 - 1;
        let at = |ring: u32, k: u32| first + ring * segments + k % segments;
        for ring in 0..last {
            for k in 0..segments {
                self.quad([at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)]);
            }
        }
        for k in 1..segments - 1 {
            self.triangles.push([at(0, 0), at(0, k + 1), at(0, k)]);
            self.triangles.push([at(last, 0), at(last, k), at(last, k + 1)]);
        }
    }

    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }
}

/// Lower line of a block with a round arch cut out of it: from `x0` to `x1` at height `z`, the arch about `middle` with `radius`.
pub fn arch(x0: f64, x1: f64, z: f64, middle: f64, radius: f64) -> Vec<DVec2> {
    const STEPS: u32 = 24;
    let mut line = vec![dvec2(x0, z)];
    line.extend((0..=STEPS).map(|k| {
        let (sin, cos) = libm::sincos(PI * f64::from(k) / f64::from(STEPS));
        dvec2(middle - radius * cos, z + radius * sin)
    }));
    line.push(dvec2(x1, z));
    line
}
