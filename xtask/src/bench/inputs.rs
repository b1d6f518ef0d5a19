//! Meshes and pictures that the scenes of the benchmark name; the same bytes on every machine.

use super::ply::Mesh;
use crate::gallery::inputs::{Canvas, Random, noise};
use glam::DVec3;
use std::fmt::Write;

/// A file in the folder `data` beside the scenes, and what makes its bytes.
pub struct Input {
    pub name: &'static str,
    pub make: fn() -> Vec<u8>,
}

/// All but the dragon, which is fetched.
pub const INPUTS: &[Input] = &[
    Input { name: "ball.ply", make: || ball(6).ply() },
    Input { name: "lamps-a.ply", make: || lamps(1).ply() },
    Input { name: "lamps-b.ply", make: || lamps(2).ply() },
    Input { name: "lamps-c.ply", make: || lamps(3).ply() },
    Input { name: "lamps-d.ply", make: || lamps(4).ply() },
    Input { name: "scattered-lamps.ply", make: || scattered_lamps().ply() },
    Input { name: "lamp-10.ply", make: || cut_lamp(5, 1).ply() },
    Input { name: "lamp-100k.ply", make: || cut_lamp(250, 200).ply() },
    Input { name: "bush.ply", make: || bush().ply() },
    Input { name: "tiles.png", make: || tiles().png() },
    Input { name: "planks.png", make: || planks().png() },
    Input { name: "paper.png", make: || paper().png() },
    Input { name: "sky.hdr", make: sky },
];

/// What is added to the end of a scene file: thousands of objects need not be kept.
pub fn more_objects(scene: &str) -> String {
    if scene == "instances" { bushes() } else { String::new() }
}

/// An icosahedron whose faces are cut into four `times` over, of radius 1.
pub fn ball(times: u32) -> Mesh {
    let g = (1.0 + 5.0f64.sqrt()) / 2.0;
    let corners = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ];
    let faces = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    let mut mesh =
        Mesh { positions: corners.map(|c| DVec3::from_array(c).normalize()).to_vec(), triangles: faces.to_vec() };
    for _ in 0..times {
        mesh = quartered(&mesh);
    }
    mesh
}

/// Every triangle made four, the new corners on the unit sphere.
fn quartered(mesh: &Mesh) -> Mesh {
    let mut finer = Mesh { positions: mesh.positions.clone(), triangles: Vec::new() };
    let mut middles = std::collections::BTreeMap::new();
    for &[a, b, c] in &mesh.triangles {
        let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[i, j]| {
            *middles.entry([i.min(j), i.max(j)]).or_insert_with(|| {
                let middle = mesh.positions[i as usize] + mesh.positions[j as usize];
                finer.positions.push(middle.normalize());
                finer.positions.len() as u32 - 1
            })
        });
        finer.triangles.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    finer
}

/// 256 octahedra of radius 3 cm over a floor, farther from each other in front of the camera than behind.
fn lamps(seed: u64) -> Mesh {
    let mut random = Random::new(seed);
    let mut mesh = Mesh::default();
    for _ in 0..256 {
        let centre = DVec3::new(7.0 * random.signed(), 0.5 + 2.5 * random.unit(), 4.5 * random.signed() - 1.5);
        let first = mesh.positions.len() as u32;
        let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        mesh.positions.extend(axes.map(|axis| centre + 0.03 * axis));
        for octant in 0..8u32 {
            let [x, y, z] = [first + (octant & 1), first + 2 + (octant >> 1 & 1), first + 4 + (octant >> 2)];
            let even = octant.count_ones().is_multiple_of(2);
            mesh.triangles.push(if even { [x, y, z] } else { [x, z, y] });
        }
    }
    mesh
}

/// 100,000 triangles with edges of some 2 cm, each turned any way, 2.2 m to 3 m above the floor.
fn scattered_lamps() -> Mesh {
    let mut random = Random::new(5);
    let mut mesh = Mesh::default();
    for i in 0..100_000 {
        let centre = DVec3::new(8.0 * random.signed(), 2.2 + 0.8 * random.unit(), 8.0 * random.signed());
        let [a, b] = [direction(&mut random), direction(&mut random)];
        let u = a.any_orthonormal_vector();
        let u = (u + 0.2 * b).normalize();
        let v = a.cross(u).normalize();
        let corners = [[1.0, 0.0], [-0.5, 0.866], [-0.5, -0.866]];
        mesh.positions.extend(corners.map(|[x, y]| centre + 0.0115 * (x * u + y * v)));
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

/// Uniform on the sphere.
fn direction(random: &mut Random) -> DVec3 {
    loop {
        let p = DVec3::new(random.signed(), random.signed(), random.signed());
        if (0.01..1.0).contains(&p.length_squared()) {
            return p.normalize();
        }
    }
}

/// A rectangle of 1 m x 0.8 m that faces down, in `columns` x `rows` rectangles of two triangles.
fn cut_lamp(columns: u32, rows: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let [x, z] = [f64::from(column) / f64::from(columns), 0.8 * f64::from(row) / f64::from(rows)];
            mesh.positions.push(DVec3::new(1.5 + x, 2.99, 1.4 + z));
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let a = row * (columns + 1) + column;
            let c = a + columns + 1;
            mesh.triangles.extend([[a, a + 1, c], [a + 1, c + 1, c]]);
        }
    }
    mesh
}

/// Leaves of two triangles in a ball of radius 0.5 that stands on the origin.
fn bush() -> Mesh {
    let mut random = Random::new(6);
    let mut mesh = Mesh::default();
    for _ in 0..3000 {
        let out = direction(&mut random);
        let centre = out * 0.5 * random.unit().sqrt() + 0.5 * DVec3::Y;
        let along = (out + 0.8 * direction(&mut random)).normalize();
        let across = along.cross(direction(&mut random)).normalize();
        let first = mesh.positions.len() as u32;
        let corners = [-0.045 * along, 0.012 * across, 0.045 * along, -0.012 * across];
        mesh.positions.extend(corners.map(|c| centre + c));
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    mesh
}

/// 64 x 64 bushes on a field, each turned and scaled by chance.
fn bushes() -> String {
    let mut random = Random::new(7);
    let mut text = String::new();
    for i in 0..4096u32 {
        let cell = [i % 64, i / 64].map(f64::from);
        let x = (cell[0] - 31.5) * 0.8 + 0.5 * random.signed();
        let z = (cell[1] - 50.0) * 0.9 + 0.5 * random.signed();
        let (angle, scale) = (360.0 * random.unit(), 0.5 + 0.7 * random.unit());
        let _ = write!(
            text,
            "\n[[objects]]\nmesh = \"bush\"\nmaterial = \"leaf\"\ntransform = [{{ scale = {scale:.3} }}, \
             {{ rotate = {{ axis = \"y\", angle = {angle:.2} }} }}, {{ translate = [{x:.3}, 0.0, {z:.3}] }}]\n"
        );
    }
    text
}

/// Square tiles of chance colours with pale joints.
fn tiles() -> Canvas<3> {
    let mut picture = Canvas::new(512, 512, [0.0; 3]);
    picture.shade(|p, _| {
        let cell = (p / 128.0).floor();
        let inside = p / 128.0 - cell;
        let edge = inside.min(1.0 - inside).min_element();
        let of = |seed| 0.5 + 0.5 * noise([cell.x, cell.y, 0.0], seed);
        let grain = 0.08 * noise([p.x / 9.0, p.y / 9.0, 0.0], 4);
        if edge < 0.03 {
            return [0.75, 0.73, 0.7];
        }
        [0.25 + 0.4 * of(1) + grain, 0.2 + 0.3 * of(2) + grain, 0.15 + 0.2 * of(3) + grain]
    });
    picture
}

/// Boards with grain along u.
fn planks() -> Canvas<3> {
    let mut picture = Canvas::new(512, 512, [0.0; 3]);
    picture.shade(|p, _| {
        let board = (p.y / 64.0).floor();
        let grain = noise([p.x / 90.0, p.y / 4.0, board], 8) + 0.5 * noise([p.x / 30.0, p.y / 2.0, board], 9);
        let tone = 0.8 + 0.25 * noise([board, 0.5, 0.5], 10) + 0.12 * grain;
        let joint = if p.y - 64.0 * board < 3.0 { 0.35 } else { 1.0 };
        [0.55, 0.36, 0.2].map(|c| c * tone * joint)
    });
    picture
}

/// Wallpaper of soft rings and stripes.
fn paper() -> Canvas<3> {
    let mut picture = Canvas::new(512, 512, [0.0; 3]);
    picture.shade(|p, _| {
        let ring = ((p - 256.0).length() / 24.0).fract();
        let stripe = (p.x / 32.0).floor() % 2.0;
        let t = 4.0 * ring * (1.0 - ring);
        [0.5 + 0.3 * t, 0.6 - 0.2 * t + 0.15 * stripe, 0.45 + 0.1 * stripe]
    });
    picture
}

/// A sky from white to blue with a sun of radius 3 degrees, 1024 x 512, in flat RGBE (G. Ward, "Real Pixels", Graphics Gems II,
/// 1991). Its columns are longitudes as docs/scene-format.md has them, the middle one being +z.
fn sky() -> Vec<u8> {
    let (width, height) = (1024u32, 512u32);
    let sun = DVec3::new(-0.55, 0.6, 0.45).normalize();
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    for y in 0..height {
        let polar = std::f64::consts::PI * (f64::from(y) + 0.5) / f64::from(height);
        let (sin, cos) = libm::sincos(polar);
        for x in 0..width {
            let longitude = std::f64::consts::TAU * ((f64::from(x) + 0.5) / f64::from(width) - 0.5);
            let (s, c) = libm::sincos(longitude);
            let towards = DVec3::new(-sin * s, cos, sin * c);
            let up = towards.y.max(0.0);
            let colour = if towards.dot(sun) > 0.998_629_5 {
                [330.0, 310.0, 270.0]
            } else if towards.y < 0.0 {
                [0.25, 0.22, 0.2]
            } else {
                [0.9 - 0.6 * up, 0.95 - 0.45 * up, 1.0 - 0.15 * up]
            };
            bytes.extend(rgbe(colour));
        }
    }
    bytes
}

/// Three mantissas and their common exponent.
fn rgbe(colour: [f64; 3]) -> [u8; 4] {
    let (_, exponent) = libm::frexp(colour.into_iter().fold(0.0, f64::max));
    let scale = libm::ldexp(256.0, -exponent);
    let [r, g, b] = colour.map(|c| (c * scale).min(255.0) as u8);
    [r, g, b, (exponent + 128) as u8]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_have_the_sizes_that_the_scenes_say() {
        assert_eq!(ball(6).triangles.len(), 81_920);
        assert_eq!((1..=4).map(|seed| lamps(seed).triangles.len()).sum::<usize>(), 8_192);
        assert_eq!(scattered_lamps().triangles.len(), 100_000);
        assert_eq!([cut_lamp(5, 1), cut_lamp(250, 200)].map(|lamp| lamp.triangles.len()), [10, 100_000]);
        assert_eq!(bush().triangles.len(), 6_000);
        assert_eq!(bushes().matches("[[objects]]").count(), 4096);
    }

    #[test]
    fn normals_point_where_they_should() {
        let normal = |mesh: &Mesh, t: [u32; 3]| {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            ((b - a).cross(c - a), (a + b + c) / 3.0)
        };
        let ball = ball(2);
        assert!(ball.triangles.iter().all(|&t| {
            let (n, p) = normal(&ball, t);
            n.dot(p) > 0.0
        }));
        let lamps = lamps(1);
        assert!(lamps.triangles.iter().enumerate().all(|(i, &t)| {
            let first = i / 8 * 6;
            let centre = (lamps.positions[first] + lamps.positions[first + 1]) / 2.0;
            let (n, p) = normal(&lamps, t);
            n.dot(p - centre) > 0.0
        }));
        let lamp = cut_lamp(5, 1);
        let area: f64 = lamp.triangles.iter().map(|&t| -normal(&lamp, t).0.y / 2.0).sum();
        assert!((area - 0.8).abs() < 1e-9, "{area}");
    }

    #[test]
    fn colours_survive_a_common_exponent() {
        for colour in [[330.0, 310.0, 270.0], [0.25, 0.22, 0.2], [1.0, 0.5, 0.001]] {
            let [r, g, b, e] = rgbe(colour);
            for (stored, c) in [r, g, b].into_iter().zip(colour) {
                let value = (f64::from(stored) + 0.5) * libm::ldexp(1.0, i32::from(e) - 136);
                let largest = colour.into_iter().fold(0.0, f64::max);
                assert!((value - c).abs() <= largest / 256.0, "{value} {c}");
            }
        }
    }
}
