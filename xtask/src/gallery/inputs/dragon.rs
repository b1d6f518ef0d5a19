//! A dragon in glass or porcelain, standing as the well-known scan does: a long body that rises, arches and falls, four short legs,
//! a tail that curls up beside the hips, horns, a mane, an open mouth. The sculpture is the project's own.

use super::{
    mesh::Mesh,
    polygonise::{Field, polygonise, relax},
    random::fractal,
    shapes::{Cone, Ellipsoid, cut, union},
};
use glam::{DVec3, dvec3};
use std::f64::consts::PI;

/// Extents of the finished model, metres: those of the scan when its length is 2, so that either can stand for the other.
const EXTENTS: DVec3 = dvec3(0.892, 2.0, 1.413);
/// Faces of the mesh that the figures use, about.
pub const FACES: usize = 56_000;
/// What positions are rounded to.
pub const QUANTUM: f64 = 1.0 / 16_000.0;

/// A closed mesh of about so many faces: z up, head towards -y, the lowest corner of its bounding box at the origin.
pub fn mesh(faces: usize) -> Mesh {
    let dragon = Dragon::new();
    // Faces grow with the square of the fineness.
    let mut cell = 0.0185 * (FACES as f64 / faces as f64).sqrt();
    let mut mesh = dragon.polygonise(cell);
    for _ in 0..2 {
        if mesh.triangles.len().abs_diff(faces) * 50 < faces {
            break;
        }
        cell *= (mesh.triangles.len() as f64 / faces as f64).sqrt();
        mesh = dragon.polygonise(cell);
    }
    mesh.keep_largest();
    relax(&dragon, &mut mesh, cell);
    let [low, high] = mesh.bounds();
    // A quarter of a turn, so that the head looks towards -y.
    let turned = |p: DVec3| dvec3(high.y - p.y, p.x - low.x, p.z - low.z);
    let stretch = EXTENTS / dvec3(high.y - low.y, high.x - low.x, high.z - low.z);
    for p in &mut mesh.positions {
        *p = turned(*p) * stretch;
    }
    mesh
}

/// A part, joined to or taken from what was there before.
enum Part {
    Cone(Cone),
    Ball(Ellipsoid),
    Hole(Ellipsoid),
}

impl Part {
    fn at_least(&self, p: DVec3) -> f64 {
        match self {
            Self::Cone(cone) => cone.at_least(p),
            Self::Ball(ball) | Self::Hole(ball) => ball.at_least(p),
        }
    }

    fn join(&self, d: f64, p: DVec3) -> f64 {
        match self {
            Self::Cone(cone) if cone.at_least(p) < d + cone.blend => union(d, cone.distance(p).0, cone.blend),
            Self::Ball(ball) if ball.at_least(p) < d + ball.blend => union(d, ball.distance(p), ball.blend),
            Self::Hole(hole) if hole.at_least(p) < hole.blend - d => cut(d, hole.distance(p), hole.blend),
            _ => d,
        }
    }
}

/// A piece of the body's middle line.
struct Vertebra {
    cone: Cone,
    /// Of its two ends: how far along the body, counted in radii.
    along: [f64; 2],
    tangent: DVec3,
    /// Towards the ridge on the back.
    back: DVec3,
    radius: f64,
}

struct Dragon {
    spine: Vec<Vertebra>,
    parts: Vec<Part>,
    /// For each cube of space the parts near it, in order.
    near: Vec<Vec<u16>>,
}

/// Space that holds the dragon while it is made, in cubes of `CUBE`.
const LOW: DVec3 = dvec3(-1.25, -0.75, -0.15);
const CUBES: [usize; 3] = [20, 12, 15];
const CUBE: f64 = 0.125;
/// Parts farther than this from a cube are left out there: no distance is told to be larger.
const NEAR: f64 = 0.25;

/// The middle line of the body and its radius, from the head to the tip of the tail.
const SPINE: &[(f64, f64, f64, f64)] = &[
    (-0.25, -0.06, 1.13, 0.13),
    (-0.275, -0.04, 0.97, 0.142),
    (-0.37, -0.01, 0.77, 0.16),
    (-0.49, 0.0, 0.57, 0.19),
    (-0.535, 0.01, 0.39, 0.222),
    (-0.46, 0.03, 0.25, 0.232),
    (-0.29, 0.06, 0.23, 0.215),
    (-0.13, 0.09, 0.36, 0.195),
    (-0.02, 0.11, 0.56, 0.182),
    (0.09, 0.12, 0.76, 0.176),
    (0.24, 0.12, 0.89, 0.175),
    (0.42, 0.11, 0.89, 0.175),
    (0.57, 0.09, 0.76, 0.178),
    (0.62, 0.06, 0.55, 0.186),
    (0.56, 0.02, 0.35, 0.2),
    (0.47, -0.05, 0.22, 0.195),
    (0.5, -0.15, 0.16, 0.15),
    (0.66, -0.23, 0.13, 0.118),
    (0.82, -0.2, 0.19, 0.104),
    (0.91, -0.11, 0.36, 0.092),
    (0.905, -0.03, 0.56, 0.078),
    (0.84, 0.03, 0.73, 0.06),
    (0.83, 0.03, 0.84, 0.045),
    (0.86, 0.02, 0.92, 0.034),
];

impl Dragon {
    fn new() -> Self {
        let mut dragon = Self { spine: spine(), parts: Vec::new(), near: Vec::new() };
        dragon.legs();
        dragon.head();
        dragon.ridge();
        dragon.tuft();
        let middles = (0..CUBES.iter().product()).map(|i: usize| {
            let cube = dvec3((i % CUBES[0]) as f64, (i / CUBES[0] % CUBES[1]) as f64, (i / CUBES[0] / CUBES[1]) as f64);
            LOW + (cube + 0.5) * CUBE
        });
        let close = |part: &Part, middle| part.at_least(middle) < NEAR + CUBE;
        let near =
            |middle| (0..dragon.parts.len() as u16).filter(|&i| close(&dragon.parts[usize::from(i)], middle)).collect();
        dragon.near = middles.map(near).collect();
        dragon
    }

    /// Distance to body and parts, joined.
    fn joined(&self, body: f64, p: DVec3) -> f64 {
        let cube = ((p - LOW) / CUBE).to_array();
        let [x, y, z] = [0, 1, 2].map(|i| (cube[i].max(0.0) as usize).min(CUBES[i] - 1));
        let near = &self.near[(z * CUBES[1] + y) * CUBES[0] + x];
        near.iter().fold(body, |d, &i| self.parts[usize::from(i)].join(d, p)).min(NEAR)
    }

    fn polygonise(&self, cell: f64) -> Mesh {
        polygonise(self, LOW, LOW + DVec3::from_array(CUBES.map(|n| n as f64 * CUBE)), cell)
    }

    /// Cones from point to point, each `(x, y, z, radius)`.
    fn limb(&mut self, points: &[(DVec3, f64)], blend: f64) {
        for (i, pair) in points.windows(2).enumerate() {
            // Only the first joint is soft; the pieces meet in equal radii.
            let blend = if i == 0 { blend } else { 0.4 * blend };
            self.parts.push(Part::Cone(Cone::new(pair[0], pair[1], blend)));
        }
    }

    fn ball(&mut self, middle: DVec3, axes: [DVec3; 3], radii: DVec3, blend: f64) {
        self.parts.push(Part::Ball(Ellipsoid { middle, axes, radii, blend }));
    }

    fn legs(&mut self) {
        // Front legs: shoulder, elbow, wrist; then hind legs: hip, knee, ankle. The side is the sign of y.
        let front = [dvec3(-0.44, -0.12, 0.33), dvec3(-0.25, -0.27, 0.25), dvec3(-0.46, -0.32, 0.085)];
        self.leg(-1.0, front, dvec3(-0.95, -0.2, 0.0), 1.0);
        let front = [dvec3(-0.46, 0.13, 0.33), dvec3(-0.31, 0.26, 0.24), dvec3(-0.58, 0.27, 0.085)];
        self.leg(1.0, front, dvec3(-0.98, 0.08, 0.0), 1.0);
        let hind = [dvec3(0.44, -0.1, 0.3), dvec3(0.25, -0.24, 0.31), dvec3(0.34, -0.31, 0.085)];
        self.leg(-1.0, hind, dvec3(-0.9, -0.3, 0.0), 1.06);
        let hind = [dvec3(0.54, 0.1, 0.32), dvec3(0.36, 0.25, 0.3), dvec3(0.5, 0.28, 0.085)];
        self.leg(1.0, hind, dvec3(-0.9, 0.3, 0.0), 1.06);
    }

    fn leg(&mut self, side: f64, [top, middle, end]: [DVec3; 3], toes: DVec3, size: f64) {
        let toes = toes.normalize();
        self.ball(top.lerp(middle, 0.25), [DVec3::X, DVec3::Y, DVec3::Z], dvec3(0.165, 0.12, 0.17) * size, 0.07);
        self.limb(&[(top, 0.13 * size), (middle, 0.088 * size), (end, 0.062 * size)], 0.06);
        self.ball(middle, [DVec3::X, DVec3::Y, DVec3::Z], DVec3::splat(0.095 * size), 0.04);
        // Flames of fur that blow back from the joints.
        let back = dvec3(1.0, 0.25 * side, 0.0);
        for k in 0..4 {
            let k = f64::from(k);
            let root = middle + dvec3(0.02, 0.03 * side, 0.07 - 0.045 * k);
            let tip = root + back * (0.16 - 0.02 * k) + dvec3(0.0, 0.03 * side, 0.1 - 0.05 * k);
            self.limb(&[(root, 0.045), (root.lerp(tip, 0.55) - DVec3::Z * 0.012, 0.026), (tip, 0.009)], 0.025);
        }
        // The paw and its claws.
        let across = DVec3::Z.cross(toes);
        let paw = end + toes * 0.05 - DVec3::Z * 0.03;
        self.ball(paw, [toes, across, DVec3::Z], dvec3(0.105, 0.085, 0.052) * size, 0.04);
        for k in -1..=2 {
            let turn = if k == 2 { -across * side * 1.1 - toes * 0.25 } else { across * f64::from(k) * 0.62 + toes };
            let way = turn.normalize();
            let root = DVec3 { z: 0.05, ..paw } + way * 0.04;
            let knuckle = root + way * 0.085 + DVec3::Z * 0.012;
            let nail = knuckle + way * 0.055 - DVec3::Z * 0.025;
            let tip = nail + way * 0.045 - DVec3::Z * 0.012;
            self.limb(&[(root, 0.032), (knuckle, 0.034), (nail, 0.024), (tip, 0.009)], 0.02);
        }
    }

    fn head(&mut self) {
        let forward = dvec3(-0.955, -0.27, 0.05).normalize();
        let side = forward.cross(DVec3::Z).normalize();
        let up = side.cross(forward);
        let axes = [forward, side, up];
        let origin = dvec3(-0.36, -0.075, 1.14);
        let at = |u: f64, v: f64, w: f64| origin + forward * u + side * v + up * w;

        // Skull, snout and nose.
        self.ball(at(0.0, 0.0, 0.0), axes, dvec3(0.19, 0.135, 0.125), 0.07);
        self.limb(&[(at(0.02, 0.0, 0.0), 0.115), (at(0.28, 0.0, 0.015), 0.085), (at(0.43, 0.0, 0.05), 0.066)], 0.05);
        for v in [-1.0, 1.0] {
            self.limb(
                &[(at(0.1, 0.1 * v, -0.03), 0.05), (at(0.3, 0.07 * v, -0.035), 0.04), (at(0.47, 0.045 * v, 0.0), 0.04)],
                0.03,
            );
            self.ball(at(0.49, 0.036 * v, 0.075), axes, dvec3(0.05, 0.042, 0.046), 0.025);
            self.parts.push(Part::Hole(Ellipsoid {
                middle: at(0.525, 0.055 * v, 0.085),
                axes,
                radii: dvec3(0.024, 0.017, 0.02),
                blend: 0.012,
            }));
            // A scroll on the nose.
            self.limb(
                &[
                    (at(0.43, 0.03 * v, 0.11), 0.026),
                    (at(0.39, 0.05 * v, 0.15), 0.022),
                    (at(0.35, 0.055 * v, 0.13), 0.012),
                ],
                0.02,
            );
        }
        self.limb(&[(at(0.12, 0.0, 0.1), 0.035), (at(0.3, 0.0, 0.105), 0.026), (at(0.42, 0.0, 0.125), 0.022)], 0.025);

        // The lower jaw, open, with a beard.
        for v in [-1.0, 1.0] {
            self.limb(
                &[
                    (at(-0.04, 0.085 * v, -0.09), 0.06),
                    (at(0.2, 0.068 * v, -0.185), 0.046),
                    (at(0.42, 0.035 * v, -0.195), 0.036),
                ],
                0.035,
            );
        }
        self.limb(
            &[
                (at(0.0, 0.0, -0.12), 0.075),
                (at(0.22, 0.0, -0.205), 0.04),
                (at(0.44, 0.0, -0.205), 0.036),
                (at(0.55, 0.0, -0.15), 0.014),
            ],
            0.035,
        );
        for (v, long) in [(0.0, 1.0), (-1.0, 0.75), (1.0, 0.75)] {
            let root = at(0.33 - 0.1 * v * v, 0.05 * v, -0.225);
            let tip = at(0.2 - 0.16 * v * v, 0.075 * v, -0.245 - 0.13 * long);
            self.limb(&[(root, 0.034), (root.lerp(tip, 0.5) + forward * 0.025, 0.02), (tip, 0.009)], 0.02);
        }
        self.limb(
            &[
                (at(0.03, 0.0, -0.1), 0.036),
                (at(0.24, 0.0, -0.145), 0.03),
                (at(0.4, 0.01, -0.14), 0.024),
                (at(0.48, 0.02, -0.1), 0.012),
            ],
            0.01,
        );
        // Teeth.
        for v in [-1.0, 1.0] {
            for k in 0..4 {
                let k = f64::from(k);
                let (u, size) = (0.2 + 0.085 * k, if k == 3.0 { 1.5 } else { 0.9 });
                let (side, root) = (v * (0.085 - 0.014 * k), -0.055 + 0.02 * (k - 1.0).max(0.0));
                self.limb(&[(at(u, side, root), 0.02), (at(u + 0.005, side, root - 0.055 * size), 0.007)], 0.01);
            }
            for k in 0..3 {
                let u = 0.24 + 0.085 * f64::from(k);
                let (side, root) = (v * (0.07 - 0.015 * f64::from(k)), -0.165);
                self.limb(&[(at(u, side, root), 0.019), (at(u - 0.005, side, root + 0.055), 0.007)], 0.01);
            }
        }

        // Brows, eyes, cheeks, ears.
        for v in [-1.0, 1.0] {
            self.limb(
                &[
                    (at(0.2, 0.06 * v, 0.085), 0.036),
                    (at(0.08, 0.105 * v, 0.115), 0.036),
                    (at(-0.05, 0.13 * v, 0.15), 0.012),
                ],
                0.02,
            );
            self.ball(at(0.125, 0.1 * v, 0.058), axes, DVec3::splat(0.034), 0.008);
            self.ball(at(0.0, 0.105 * v, -0.055), axes, dvec3(0.08, 0.055, 0.07), 0.03);
            self.limb(
                &[
                    (at(-0.07, 0.11 * v, 0.06), 0.04),
                    (at(-0.17, 0.18 * v, 0.1), 0.034),
                    (at(-0.25, 0.22 * v, 0.13), 0.01),
                ],
                0.02,
            );
            // Horns with a second tine.
            self.limb(
                &[
                    (at(-0.03, 0.06 * v, 0.1), 0.046),
                    (at(-0.14, 0.085 * v, 0.175), 0.036),
                    (at(-0.28, 0.105 * v, 0.205), 0.027),
                    (at(-0.4, 0.13 * v, 0.23 + 0.02 * v), 0.016),
                    (at(-0.47, 0.15 * v, 0.26 + 0.03 * v), 0.009),
                ],
                0.025,
            );
            self.limb(
                &[
                    (at(-0.1, 0.08 * v, 0.15), 0.03),
                    (at(-0.13, 0.09 * v, 0.22), 0.022),
                    (at(-0.19, 0.1 * v, 0.3 - 0.02 * v), 0.009),
                ],
                0.02,
            );
            // The mane: locks in two rows that stand off from cheek and neck.
            for k in 0..6 {
                let k = f64::from(k);
                let root = at(-0.06 - 0.012 * k, v * (0.1 + 0.01 * k), 0.04 - 0.045 * k);
                let tip = at(-0.27 + 0.02 * k, v * (0.2 + 0.012 * k), 0.05 - 0.075 * k);
                self.limb(&[(root, 0.042), (root.lerp(tip, 0.5) - up * 0.02, 0.03), (tip, 0.009)], 0.02);
            }
            for k in 0..5 {
                let k = f64::from(k);
                let root = at(-0.11, v * (0.07 - 0.004 * k), 0.06 - 0.06 * k);
                let tip = at(-0.33, v * (0.12 + 0.004 * k), 0.06 - 0.085 * k);
                self.limb(&[(root, 0.05), (root.lerp(tip, 0.5) - up * 0.02, 0.034), (tip, 0.009)], 0.02);
            }
        }
    }

    /// Spikes along the back.
    fn ridge(&mut self) {
        /// From one to the next, in radii of the body.
        const APART: f64 = 0.4;
        let mut next = 1.3;
        let mut spikes = Vec::new();
        for piece in &self.spine {
            while next < piece.along[1] {
                let t = (next - piece.along[0]) / (piece.along[1] - piece.along[0]);
                next += APART;
                let size = (piece.radius / 0.18).clamp(0.5, 1.1);
                let root = piece.cone.on_axis(t) + piece.back * (piece.radius * 0.94);
                let tip = root + piece.back * (0.075 * size) + piece.tangent * (0.06 * size);
                spikes.push([
                    (root - piece.tangent * 0.012, 0.034 * size),
                    (root.lerp(tip, 0.45), 0.024 * size),
                    (tip, 0.009),
                ]);
            }
        }
        for spike in spikes {
            self.limb(&spike, 0.014);
        }
    }

    /// The flame at the end of the tail.
    fn tuft(&mut self) {
        let root = dvec3(0.85, 0.02, 0.87);
        for (k, (long, lean)) in
            [(0.2, -0.75), (0.25, -0.35), (0.27, 0.05), (0.24, 0.45), (0.18, 0.85)].into_iter().enumerate()
        {
            let way = dvec3(0.55 + 0.5 * lean, 0.12 * (k as f64 - 2.0), 0.8 - 0.55 * lean).normalize();
            let tip = root + way * long;
            let bow = dvec3(way.z, 0.0, -way.x) * 0.02;
            self.limb(&[(root, 0.034), (root.lerp(tip, 0.5) + bow, 0.03), (tip, 0.009)], 0.018);
        }
    }
}

/// A smooth curve through [`SPINE`], in short pieces.
fn spine() -> Vec<Vertebra> {
    const STEPS: usize = 8;
    let at = |i: isize| {
        let (x, y, z, r) = SPINE[i.clamp(0, SPINE.len() as isize - 1) as usize];
        glam::DVec4::new(x, y, z, r)
    };
    let mut points = Vec::new();
    for i in 0..SPINE.len() as isize - 1 {
        let [a, b, c, d] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
        for step in 0..STEPS {
            let t = step as f64 / STEPS as f64;
            let p = 2.0 * b
                + (c - a) * t
                + (2.0 * a - 5.0 * b + 4.0 * c - d) * (t * t)
                + (3.0 * (b - c) + d - a) * (t * t * t);
            points.push(0.5 * p);
        }
    }
    points.push(at(SPINE.len() as isize));
    let mut along = 0.0;
    points
        .windows(2)
        .map(|pair| {
            let [a, b] = [pair[0].truncate(), pair[1].truncate()];
            let [ra, rb] = [pair[0].w, pair[1].w];
            let start = along;
            along += a.distance(b) / (0.5 * (ra + rb));
            let tangent = (b - a).normalize();
            let back = dvec3(-tangent.z, 0.0, tangent.x);
            let back = (back - tangent * back.dot(tangent)).normalize();
            Vertebra { cone: Cone::new((a, ra), (b, rb), 0.0), along: [start, along], tangent, back, radius: ra }
        })
        .collect()
}

impl Field for Dragon {
    fn at(&self, p: DVec3) -> f64 {
        let mut body = f64::INFINITY;
        let mut nearest = (0, 0.0);
        for (i, piece) in self.spine.iter().enumerate() {
            if piece.cone.at_least(p) < body {
                let (d, t) = piece.cone.distance(p);
                if d < body {
                    (body, nearest) = (d, (i, t));
                }
            }
        }
        let smooth = self.joined(body, p);
        if smooth.abs() > 0.06 {
            return smooth;
        }
        let (i, t) = nearest;
        // Scales only where the surface is that of the body itself.
        let bare = (1.0 - (body - smooth) / 0.02).clamp(0.0, 1.0);
        let skin = 0.006 * fractal((p * 9.0).to_array(), 2, 7) + 0.0025 * fractal((p * 45.0).to_array(), 1, 8);
        smooth - skin - bare * self.spine[i].relief(p, t)
    }
}

impl Vertebra {
    /// Height of scales on the back and sides, and of plates on the belly.
    fn relief(&self, p: DVec3, t: f64) -> f64 {
        /// Scales around the body.
        const AROUND: f64 = 28.0;
        let along = self.along[0] + (self.along[1] - self.along[0]) * t;
        let off = p - self.cone.on_axis(0.0);
        let angle = libm::atan2(off.dot(self.tangent.cross(self.back)), off.dot(self.back));
        let strength = (self.radius / 0.18).min(1.1);
        let to_belly = ((angle.abs() - 2.0) / 0.25).clamp(0.0, 1.0);
        // Lozenges: the lattice stands on its corner.
        let (u, v) = (along * AROUND / (4.0 * PI), angle * AROUND / (2.0 * PI));
        let bump = |x: f64| {
            let x = x - x.floor();
            libm::sqrt((4.0 * x * (1.0 - x)).max(0.0))
        };
        let scale = bump(u + 0.5 * v) * bump(u - 0.5 * v);
        let plate = bump(along * 2.6);
        0.011 * strength * ((1.0 - to_belly) * scale + to_belly * 1.3 * plate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dragon_is_one_closed_solid() {
        let dragon = mesh(14_000);
        assert!((13_500..14_500).contains(&dragon.triangles.len()), "{}", dragon.triangles.len());
        assert_eq!(dragon.open_edges(), 0);
        let solids: Vec<f64> = dragon.solids().into_values().collect();
        assert!(solids.len() == 1 && solids[0] > 0.3, "{solids:?}");
        let [low, high] = dragon.bounds();
        assert!(low.length() < 1e-9 && high.distance(EXTENTS) < 1e-9, "{low} {high}");
    }
}
