//! Models with sharp and smooth parts, the same on every machine.

use super::{dragon, place};
use crate::bench::{ply::Mesh, scenes};
use glam::{DVec2, DVec3, dvec2, dvec3};
use libm::{cos, fabs, sin};
use std::{collections::BTreeMap, f64::consts::TAU, path::PathBuf};

/// What is simplified, and to how many faces.
pub struct Model {
    pub name: &'static str,
    pub what: &'static str,
    pub faces: usize,
    pub sizes: &'static [usize],
    /// Absent: the dragon, which is fetched.
    make: Option<fn() -> Mesh>,
}

/// All of them.
pub const ALL: &[Model] = &[
    Model {
        name: "dragon",
        what: "The Stanford dragon, 871,306 faces",
        faces: 871_306,
        sizes: &[10_000, 1_000],
        make: None,
    },
    Model {
        name: "gear",
        what: "A gear with hub, web and chamfered rim, 460,800 faces",
        faces: 460_800,
        sizes: &[20_000, 5_000, 1_500],
        make: Some(gear),
    },
    Model {
        name: "vase",
        what: "A vase with flutes that meet in ridges, soft bumps, a sharp rim and foot, 465,920 faces",
        faces: 465_920,
        sizes: &[20_000, 5_000, 1_000],
        make: Some(vase),
    },
    Model {
        name: "plate",
        what: "A plate with rounded and chamfered edges and six countersunk holes, 382,464 faces",
        faces: 382_464,
        sizes: &[10_000, 3_000, 1_000],
        make: Some(plate),
    },
];

impl Model {
    /// Its PLY file, made or fetched if it is not there, and what is wanted of it.
    pub fn subject(&self) -> Result<Subject, String> {
        let path = match self.make {
            None => dragon()?,
            Some(make) => {
                let path = place().join(format!("{}.ply", self.name));
                scenes::write(&path, &make().ply())?;
                path
            }
        };
        Ok(Subject {
            name: self.name.to_owned(),
            what: self.what.to_owned(),
            faces: self.faces,
            sizes: self.sizes.to_vec(),
            path,
            is_own: self.make.is_some(),
        })
    }
}

/// A file that is simplified, to some numbers of faces.
pub struct Subject {
    pub name: String,
    pub what: String,
    pub faces: usize,
    pub sizes: Vec<usize>,
    pub path: PathBuf,
    /// True if the project makes it.
    pub is_own: bool,
}

/// A gear with hub, thin web, rim and chamfered teeth: 24 teeth with flat tops, sharp edges all over, round flanks.
pub fn gear() -> Mesh {
    const TEETH: usize = 24;
    const AROUND: usize = TEETH * 32;
    // Height over the section from the bore to the tips and back: (share of the way out, height).
    let upper = [(0.0, 0.42), (0.30, 0.42), (0.32, 0.36), (0.36, 0.16), (0.40, 0.14), (0.66, 0.14), (0.70, 0.16)];
    let rim = [(0.74, 0.28), (0.76, 0.30), (0.97, 0.30), (1.0, 0.26)];
    let half: Vec<DVec2> = upper.iter().chain(&rim).map(|&(out, height)| dvec2(out, height)).collect();
    let mut section = half.clone();
    section.extend(half.iter().rev().map(|p| dvec2(p.x, -p.y)));
    // Inside of the surface lies to the left on the way round.
    section.reverse();
    let section = &cut(&section, 0.014, true);
    let ring = |i: usize| {
        let turn = i as f64 / AROUND as f64;
        let reach = tooth((turn * TEETH as f64).fract());
        let (s, c) = (sin(TAU * turn), cos(TAU * turn));
        section.iter().map(move |p| {
            // Only the rim has teeth: what is further in is round.
            let toothed = ((p.x - 0.78) / 0.22).clamp(0.0, 1.0);
            let radius = 0.3 + 0.7 * p.x + toothed * reach;
            dvec3(radius * c, p.y, radius * s)
        })
    };
    swept(AROUND, true, |i| ring(i).collect())
}

/// How far a tooth stands out, over one period: root, flank, top, flank.
fn tooth(t: f64) -> f64 {
    const HEIGHT: f64 = 0.16;
    match t {
        t if t < 0.25 => 0.0,
        // Flanks are arcs that end at sharp tips.
        t if t < 0.40625 => HEIGHT * sin(TAU / 4.0 * (t - 0.25) / 0.15625),
        t if t < 0.71875 => HEIGHT,
        t if t < 0.875 => HEIGHT * sin(TAU / 4.0 * (0.875 - t) / 0.15625),
        _ => 0.0,
    }
}

/// A vase turned on a wheel: flutes that meet in ridges below, soft bumps above, a sharp rim and foot.
pub fn vase() -> Mesh {
    const AROUND: usize = 560;
    let outline = [
        (0.0, 0.0),
        (0.30, 0.0),
        (0.32, 0.03),
        (0.26, 0.06),
        (0.30, 0.16),
        (0.46, 0.36),
        (0.52, 0.56),
        (0.46, 0.78),
        (0.28, 0.98),
        (0.22, 1.08),
        (0.24, 1.16),
        (0.34, 1.24),
        (0.34, 1.26),
        (0.31, 1.26),
        (0.20, 1.16),
        (0.18, 1.08),
        (0.24, 0.98),
        (0.42, 0.76),
        (0.47, 0.56),
        (0.41, 0.36),
        (0.24, 0.14),
        (0.0, 0.11),
    ];
    let corners: Vec<DVec2> = outline.iter().map(|&(r, y)| dvec2(r, y)).collect();
    // The foot, the rim and the two ends stay sharp, the body in between is smooth.
    let mut section = corners[..4].to_vec();
    section.extend(smooth(&corners[3..12]));
    section.extend_from_slice(&corners[11..14]);
    section.extend(smooth(&corners[13..22]));
    section.push(corners[21]);
    let section = &cut(&section, 0.0105, false);
    let outer = section.iter().position(|p| p.y >= 1.24).unwrap_or(section.len());
    let ring = |i: usize| {
        let turn = i as f64 / AROUND as f64;
        let (s, c) = (sin(TAU * turn), cos(TAU * turn));
        section.iter().enumerate().map(move |(k, p)| {
            let radius = p.x + if k < outer { relief(turn, p.y) } else { 0.0 };
            dvec3(radius * c, p.y, radius * s)
        })
    };
    swept(AROUND, false, |i| ring(i).collect())
}

/// On the vase's outside at a height.
fn relief(turn: f64, y: f64) -> f64 {
    let within = |low: f64, high: f64| ((y - low) * (high - y) / (0.25 * (high - low) * (high - low))).clamp(0.0, 1.0);
    let flutes = 0.035 * within(0.08, 0.56) * (1.0 - fabs(sin(TAU * 8.0 * turn)));
    let bumps = 0.02 * within(0.52, 1.05) * sin(TAU * 9.0 * turn + 9.0 * y) * sin(TAU * (3.0 * turn + 5.0 * y));
    flutes + bumps
}

/// A plate of 3 x 2 holes with countersinks, rounded edges above and chamfers below.
pub fn plate() -> Mesh {
    const SIDE: usize = 48;
    const RINGS: usize = 44;
    let mut plate = Welded::default();
    for cell in 0..6 {
        let centre = dvec2(f64::from(cell % 3) - 1.0, f64::from(cell / 3) - 0.5);
        for (up, sink) in [(1.0, 0.08), (-1.0, 0.0)] {
            for side in 0..4 {
                let around = |u: f64| border(side, u).normalize();
                // From the hole's edge to the border of a square around it.
                plate.patch(SIDE, RINGS, up > 0.0, |u, v| {
                    let edge = around(u) * (0.24 + sink);
                    let p = centre + edge + (border(side, u) * 0.5 - edge) * v;
                    dvec3(p.x, up * HALF, p.y)
                });
                // A countersink above, then the wall, each half of it.
                if sink > 0.0 {
                    plate.patch(SIDE, 10, up > 0.0, |u, v| {
                        let p = centre + around(u) * (0.24 + sink * v);
                        dvec3(p.x, up * (HALF - sink * (1.0 - v)), p.y)
                    });
                }
                plate.patch(SIDE, 24, up > 0.0, |u, v| {
                    let p = centre + around(u) * 0.24;
                    dvec3(p.x, up * (HALF - sink) * v, p.y)
                });
            }
        }
    }
    plate.sides(SIDE);
    plate.mesh
}

/// Half the plate's thickness, and the radius of its rounded edges.
const HALF: f64 = 0.2;
const ROUND: f64 = 0.09;
/// Half the width and depth of its flat sides.
const FLAT: DVec2 = dvec2(1.5, 1.0);

/// A point of side 0 to 3 of the square of half width 1, counter-clockwise seen from above.
fn border(side: usize, u: f64) -> DVec2 {
    let t = 2.0 * u - 1.0;
    [dvec2(1.0, -t), dvec2(-t, -1.0), dvec2(-1.0, t), dvec2(t, 1.0)][side]
}

/// Patches of a grid each, whose vertices are joined where they are at the same place.
#[derive(Default)]
struct Welded {
    mesh: Mesh,
    numbers: BTreeMap<[i64; 3], u32>,
}

impl Welded {
    fn vertex(&mut self, p: DVec3) -> u32 {
        let key = (p * 1e7).round().to_array().map(|c| c as i64);
        *self.numbers.entry(key).or_insert_with(|| {
            self.mesh.positions.push(p);
            self.mesh.positions.len() as u32 - 1
        })
    }

    /// `at` maps the unit square; faces look where u and then v turn counter-clockwise, or away if `flip`.
    fn patch(&mut self, columns: usize, rows: usize, flip: bool, at: impl Fn(f64, f64) -> DVec3) {
        let share = |i: usize, n: usize| i as f64 / n as f64;
        let numbers: Vec<u32> = (0..=rows)
            .flat_map(|row| (0..=columns).map(move |column| (row, column)))
            .map(|(row, column)| self.vertex(at(share(column, columns), share(row, rows))))
            .collect();
        for row in 0..rows {
            for column in 0..columns {
                let a = row * (columns + 1) + column;
                let [a, b, c, d] = [a, a + 1, a + columns + 2, a + columns + 1].map(|i| numbers[i]);
                for [i, j, k] in [[a, b, c], [a, c, d]] {
                    self.mesh.triangles.push(if flip { [i, k, j] } else { [i, j, k] });
                }
            }
        }
    }

    /// The rim: a quarter circle above, a wall, a chamfer below.
    fn sides(&mut self, side: usize) {
        let outline = [(dvec2(1.0, 1.0), dvec2(1.0, -1.0), 2), (dvec2(1.0, -1.0), dvec2(-1.0, -1.0), 3)];
        let mirrored = outline.map(|(a, b, n)| (-a, -b, n));
        for (from, to, cells) in outline.into_iter().chain(mirrored) {
            let columns = cells * side;
            let at = |u: f64, out: f64, y: f64| {
                let p = (from + (to - from) * u) * (FLAT + out);
                dvec3(p.x, y, p.y)
            };
            self.patch(columns, 16, true, |u, v| {
                let angle = TAU / 4.0 * v;
                at(u, ROUND * sin(angle), HALF - ROUND + ROUND * cos(angle))
            });
            self.patch(columns, 24, true, |u, v| at(u, ROUND, HALF - ROUND - v * 2.0 * (HALF - ROUND)));
            self.patch(columns, 8, true, |u, v| at(u, ROUND * (1.0 - v), -(HALF - ROUND) - ROUND * v));
        }
    }
}

/// A polyline with points at about equal distances and at all corners.
fn cut(line: &[DVec2], step: f64, closed: bool) -> Vec<DVec2> {
    let ends = if closed { line.len() } else { line.len() - 1 };
    let mut points = Vec::new();
    for i in 0..ends {
        let (a, b) = (line[i], line[(i + 1) % line.len()]);
        let pieces = (a.distance(b) / step).ceil().max(1.0) as usize;
        points.extend((0..pieces).map(|k| a + (b - a) * (k as f64 / pieces as f64)));
    }
    if !closed {
        points.extend(line.last());
    }
    points
}

/// A Catmull-Rom spline through points, without the first and the last.
fn smooth(points: &[DVec2]) -> Vec<DVec2> {
    const PIECES: usize = 12;
    let at = |i: isize| points[i.clamp(0, points.len() as isize - 1) as usize];
    let mut line = Vec::new();
    for i in 0..points.len() as isize - 1 {
        let [a, b, c, d] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
        for k in 0..PIECES {
            let t = k as f64 / PIECES as f64;
            let (t2, t3) = (t * t, t * t * t);
            line.push(
                0.5 * (2.0 * b
                    + (c - a) * t
                    + (2.0 * a - 5.0 * b + 4.0 * c - d) * t2
                    + (3.0 * b - a - 3.0 * c + d) * t3),
            );
        }
    }
    line.remove(0);
    line
}

/// The surface that rings of equally many points make, the last one joined with the first; of sections that are not closed both
/// ends lie on the axis.
fn swept(rings: usize, closed: bool, ring: impl Fn(usize) -> Vec<DVec3>) -> Mesh {
    let mut mesh = Welded::default();
    let mut numbers: Vec<Vec<u32>> = Vec::new();
    for i in 0..rings {
        let points = ring(i);
        numbers.push(points.into_iter().map(|p| mesh.vertex(p)).collect());
    }
    let length = numbers.first().map_or(0, Vec::len);
    for i in 0..rings {
        let (here, next) = (&numbers[i], &numbers[(i + 1) % rings]);
        for k in 0..if closed { length } else { length - 1 } {
            let after = (k + 1) % length;
            let [a, b, c, d] = [here[k], here[after], next[after], next[k]];
            for t in [[a, b, c], [a, c, d]] {
                // At the axis a quadrilateral is one triangle.
                if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                    mesh.mesh.triangles.push(t);
                }
            }
        }
    }
    mesh.mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Edges without exactly one face each way, and the volume.
    fn measure(mesh: &Mesh) -> (usize, f64) {
        let mut edges: BTreeMap<[u32; 2], [u32; 2]> = BTreeMap::new();
        let mut volume = 0.0;
        for t in &mesh.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                edges.entry([a.min(b), a.max(b)]).or_default()[usize::from(a > b)] += 1;
            }
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            volume += a.dot(b.cross(c)) / 6.0;
        }
        (edges.values().filter(|uses| **uses != [1, 1]).count(), volume)
    }

    #[test]
    fn models_are_closed_and_face_outward() {
        for (name, low, high) in [("gear", 1.6, 2.0), ("vase", 0.05, 0.3), ("plate", 1.8, 2.5)] {
            let model = ALL.iter().find(|model| model.name == name).unwrap();
            let mesh = model.make.unwrap()();
            let (open, volume) = measure(&mesh);
            assert_eq!((open, mesh.triangles.len()), (0, model.faces), "{name}");
            assert!((low..high).contains(&volume), "{name}: volume {volume}");
        }
    }
}
