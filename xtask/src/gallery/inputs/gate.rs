//! A three-arched gate: a big arch between two small ones, paired columns, an attic with two towers, a mast. Blocks of glass with
//! thin gaps between them, so that each is a closed solid of its own and total reflection shows its courses.

use super::{mesh::Mesh, solids::arch};
use glam::{DVec2, dvec2, dvec3};

/// Between any two blocks, metres.
const GAP: f64 = 0.004;
/// What positions are rounded to.
const QUANTUM: f64 = 1.0 / 10_000.0;
/// The front of the walls is y = 0, their back this.
const DEPTH: f64 = 0.46;
/// Height of a course of the walls.
const COURSE: f64 = 0.0865;

/// Half the width of the openings, and where the small arch's middle is.
const BIG: f64 = 0.36;
const SMALL: f64 = 0.135;
const SMALL_MIDDLE: f64 = 1.135;
/// Where the arches begin.
const BIG_SPRING: f64 = 1.02;
const SMALL_SPRING: f64 = 0.66;
/// The outer end of the walls.
const END: f64 = 1.594;

/// The compressed PLY file.
pub fn ply_gz() -> Vec<u8> {
    mesh().ply_gz(QUANTUM)
}

/// The gate in metres: x along the front, y away from the viewer, z up, the ground in the middle of the big arch at the origin.
pub fn mesh() -> Mesh {
    let mut gate = Gate(Mesh::default());
    for side in [-1.0, 1.0] {
        gate.wing(side);
        gate.pier(side);
        gate.columns(side);
        gate.tower(side);
    }
    gate.centre();
    gate.0
}

struct Gate(Mesh);

impl Gate {
    /// A box given by ranges of x, mirrored if the side is negative, y and z.
    fn block(&mut self, side: f64, x: [f64; 2], y: [f64; 2], z: [f64; 2]) {
        let (a, b) = (side * x[0], side * x[1]);
        self.0.block(dvec3(a.min(b), y[0], z[0]), dvec3(a.max(b), y[1], z[1]));
    }

    /// A strip, mirrored if the side is negative.
    fn strip(&mut self, side: f64, lower: &[DVec2], upper: &[DVec2], y: [f64; 2]) {
        let mirrored = |line: &[DVec2]| -> Vec<DVec2> {
            if side > 0.0 { line.to_vec() } else { line.iter().rev().map(|p| dvec2(-p.x, p.y)).collect() }
        };
        self.0.strip(&mirrored(lower), &mirrored(upper), y[0], y[1]);
    }

    /// A wall in courses from `z[0]` to `z[1]`.
    fn courses(&mut self, side: f64, x: [f64; 2], z: [f64; 2]) {
        let count = ((z[1] - z[0]) / COURSE).round().max(1.0);
        let height = (z[1] - z[0]) / count;
        for k in 0..count as u32 {
            let low = z[0] + height * f64::from(k);
            // Every second course stands back a little.
            let back = 0.007 * f64::from(k % 2);
            self.block(side, [x[0] + back, x[1] - back], [back, DEPTH - back], [low, low + height - GAP]);
        }
    }

    /// The outer pier, the small arch, and what is above it.
    fn wing(&mut self, side: f64) {
        let inner = SMALL_MIDDLE + SMALL;
        self.block(side, [inner - 0.012, END + 0.02], [-0.02, DEPTH + 0.02], [0.0, 0.075]);
        self.block(side, [inner - 0.006, END + 0.01], [-0.01, DEPTH + 0.01], [0.079, 0.15]);
        self.courses(side, [inner, END], [0.154, SMALL_SPRING]);
        let lower = arch(0.9, END, SMALL_SPRING, SMALL_MIDDLE, SMALL);
        let upper: Vec<DVec2> = lower.iter().map(|p| dvec2(p.x, 0.86)).collect();
        self.strip(side, &lower, &upper, [0.0, DEPTH]);
        self.block(side, [0.91, END + 0.03], [-0.03, DEPTH + 0.03], [0.864, 0.895]);
        self.block(side, [0.91, END + 0.055], [-0.055, DEPTH + 0.055], [0.899, 0.93]);
        // The parapet, and a curve that falls from the middle part to it.
        self.block(side, [1.3, END - 0.02], [0.02, DEPTH - 0.02], [0.934, 1.06]);
        self.block(side, [1.28, END], [0.0, DEPTH], [1.064, 1.1]);
        let fall: Vec<DVec2> = (0..=16)
            .map(|k| {
                let t = f64::from(k) / 16.0;
                dvec2(0.915 + (1.27 - 0.915) * t, 0.985 + 0.27 * (1.0 - t) * (1.0 - t))
            })
            .collect();
        let ground: Vec<DVec2> = fall.iter().map(|p| dvec2(p.x, 0.934)).collect();
        self.strip(side, &ground, &fall, [0.05, DEPTH - 0.05]);
    }

    /// The pier between the big arch and a small one.
    fn pier(&mut self, side: f64) {
        let outer = SMALL_MIDDLE - SMALL;
        self.block(side, [BIG - 0.02, outer + 0.012], [-0.02, DEPTH + 0.02], [0.0, 0.075]);
        self.block(side, [BIG - 0.01, outer + 0.006], [-0.01, DEPTH + 0.01], [0.079, 0.15]);
        self.courses(side, [BIG, outer], [0.154, SMALL_SPRING]);
        self.courses(side, [BIG, 0.896], [SMALL_SPRING, BIG_SPRING - 0.044]);
        // The impost that the big arch rests on.
        self.block(side, [BIG - 0.02, 0.9], [-0.02, DEPTH + 0.02], [BIG_SPRING - 0.044, BIG_SPRING - GAP]);
    }

    /// A pedestal with two columns in front of the pier, and what they carry.
    fn columns(&mut self, side: f64) {
        let front = -0.02 - GAP;
        self.block(side, [0.43, 0.89], [-0.21, front], [0.0, 0.075]);
        self.block(side, [0.445, 0.875], [-0.195, front], [0.079, 0.15]);
        self.block(side, [0.46, 0.86], [-0.18, front], [0.154, 0.27]);
        self.block(side, [0.46, 0.86], [-0.18, front], [0.274, 0.395]);
        self.block(side, [0.44, 0.88], [-0.2, front], [0.399, 0.44]);
        for x in [0.56, 0.76] {
            let middle = dvec2(side * x, -0.105);
            let (radius, foot, top) = (0.05, 0.444, 1.27);
            let mut profile: Vec<DVec2> = [
                (1.3, 0.0),
                (1.42, 0.012),
                (1.42, 0.028),
                (1.25, 0.04),
                (1.2, 0.05),
                (1.28, 0.06),
                (1.2, 0.07),
                (1.02, 0.078),
            ]
            .map(|(r, z)| dvec2(r * radius, foot + z))
            .to_vec();
            // The shaft swells a little, in six drums.
            for drum in 0..6 {
                let (low, high) = (0.08 + 0.105 * f64::from(drum), 0.08 + 0.105 * f64::from(drum + 1));
                let width = |z: f64| 1.0 - 0.16 * (z / 0.71) * (z / 0.71);
                profile.extend([
                    dvec2(radius * width(low), foot + low + 0.006),
                    dvec2(radius * width(high), foot + high - 0.006),
                    dvec2(radius * width(high) * 0.94, foot + high),
                ]);
            }
            profile.extend(
                [(0.9, 0.722), (1.0, 0.735), (1.12, 0.76), (1.3, 0.785), (1.36, 0.8), (1.36, top - foot)]
                    .map(|(r, z)| dvec2(r * radius, foot + z)),
            );
            self.0.turned(middle, &profile, 24);
        }
        self.block(side, [0.46, 0.86], [-0.18, front], [1.274, 1.34]);
        self.block(side, [0.45, 0.87], [-0.19, front], [1.344, 1.4]);
        self.block(side, [0.43, 0.89], [-0.21, front], [1.404, 1.43]);
    }

    /// A tower at the end of the attic, with a scroll at its side.
    fn tower(&mut self, side: f64) {
        self.block(side, [0.49, 0.84], [-0.02, DEPTH - 0.02], [1.744, 1.8]);
        self.block(side, [0.51, 0.82], [0.0, DEPTH - 0.04], [1.804, 1.92]);
        self.block(side, [0.51, 0.82], [0.0, DEPTH - 0.04], [1.924, 2.04]);
        self.block(side, [0.51, 0.82], [0.0, DEPTH - 0.04], [2.044, 2.16]);
        self.block(side, [0.485, 0.845], [-0.025, DEPTH - 0.015], [2.164, 2.21]);
        self.block(side, [0.52, 0.81], [0.01, DEPTH - 0.05], [2.214, 2.27]);
        let scroll: Vec<DVec2> = (0..=12)
            .map(|k| {
                let t = f64::from(k) / 12.0;
                dvec2(0.844 + 0.12 * t, 1.77 + 0.13 * (1.0 - t) * (1.0 - t))
            })
            .collect();
        let ground: Vec<DVec2> = scroll.iter().map(|p| dvec2(p.x, 1.744)).collect();
        self.strip(side, &ground, &scroll, [0.05, DEPTH - 0.09]);
    }

    /// The big arch, the entablature, the attic and the mast.
    fn centre(&mut self) {
        let lower = arch(-0.896, 0.896, BIG_SPRING, 0.0, BIG);
        let upper: Vec<DVec2> = lower.iter().map(|p| dvec2(p.x, 1.45)).collect();
        self.0.strip(&lower, &upper, 0.0, DEPTH);
        // An archivolt in front, in voussoirs, with a keystone.
        let stones = 15;
        for k in 0..stones {
            let (a, b) = (f64::from(k) / f64::from(stones), f64::from(k + 1) / f64::from(stones));
            let cut = 0.006;
            let (outer, front) = if k == stones / 2 { (0.075, -0.05) } else { (0.05, -0.028) };
            let at = |t: f64, r: f64| {
                let (sin, cos) = libm::sincos(std::f64::consts::PI * t);
                dvec2(-r * cos, BIG_SPRING + 0.002 + r * sin)
            };
            self.voussoir(
                [at(a + cut, BIG), at(b - cut, BIG), at(b - cut, BIG + outer), at(a + cut, BIG + outer)],
                [front, -GAP],
            );
        }
        self.block(1.0, [-0.91, 0.91], [-0.03, DEPTH + 0.03], [1.454, 1.484]);
        self.block(1.0, [-0.9, 0.9], [-0.015, DEPTH + 0.015], [1.488, 1.6]);
        for k in -14..=14 {
            let x = 0.062 * f64::from(k);
            self.block(1.0, [x - 0.018, x + 0.018], [-0.075, -0.019], [1.545, 1.6]);
        }
        self.block(1.0, [-0.95, 0.95], [-0.1, DEPTH + 0.1], [1.604, 1.65]);
        self.block(1.0, [-0.985, 0.985], [-0.14, DEPTH + 0.14], [1.654, 1.69]);
        self.block(1.0, [-1.0, 1.0], [-0.16, DEPTH + 0.16], [1.694, 1.74]);
        self.block(1.0, [-0.485, 0.485], [0.03, DEPTH - 0.05], [1.744, 1.85]);
        self.block(1.0, [-0.485, 0.485], [0.03, DEPTH - 0.05], [1.854, 1.96]);
        self.block(1.0, [-0.48, 0.48], [0.0, DEPTH - 0.02], [1.964, 2.01]);
        self.block(1.0, [-0.46, 0.46], [0.05, DEPTH - 0.07], [2.014, 2.04]);
        self.block(1.0, [-0.2, 0.2], [0.09, DEPTH - 0.11], [2.044, 2.075]);
        self.block(1.0, [-0.1, 0.1], [0.13, DEPTH - 0.15], [2.079, 2.11]);
        let mast =
            [(0.02, 2.114), (0.02, 2.13), (0.011, 2.14), (0.007, 2.66), (0.012, 2.665), (0.012, 2.68), (0.004, 2.69)];
        self.0.turned(dvec2(0.0, 0.5 * DEPTH), &mast.map(|(r, z)| dvec2(r, z)), 16);
    }

    /// A stone with four corners in front, counter-clockwise from above left in x and z.
    fn voussoir(&mut self, corners: [DVec2; 4], y: [f64; 2]) {
        let first = self.0.positions.len() as u32;
        for y in y {
            self.0.positions.extend(corners.map(|c| dvec3(c.x, y, c.y)));
        }
        let mut quad = |q: [u32; 4]| {
            let q = q.map(|i| first + i);
            self.0.triangles.extend([[q[0], q[1], q[2]], [q[0], q[2], q[3]]]);
        };
        quad([0, 1, 2, 3]);
        quad([7, 6, 5, 4]);
        for i in 0..4 {
            let j = (i + 1) % 4;
            quad([j, i, 4 + i, 4 + j]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gate_is_made_of_closed_solids() {
        let gate = mesh();
        assert_eq!(gate.open_edges(), 0);
        let solids = gate.solids();
        assert!(solids.len() > 100 && solids.values().all(|volume| *volume > 1e-7), "{solids:?}");
        let [low, high] = gate.bounds();
        assert!(low.z == 0.0 && low.y > -0.25 && low.x > -1.7 && high.x < 1.7 && high.z < 2.7);
    }
}
