//! Balls, dice, cut stones and rings that fall into a bowl of glass: the meshes, and the scene with all its bodies.

use super::{Random, mesh::Mesh};
use glam::{DVec2, dvec2, dvec3};
use std::{
    f64::consts::{FRAC_PI_2, PI},
    fmt::Write,
};

/// What positions are rounded to, metres; the scene scales by it.
const QUANTUM: f64 = 0.00001;
/// Bodies that fall.
const BODIES: usize = 240;
/// Of them in one layer: one in the middle, the others round it.
const LAYER: usize = 7;
/// Metres between layers, above the half of the largest body's diagonal on both sides.
const RISE: f64 = 0.045;
/// Metres above the table of the lowest layer.
const LOWEST: f64 = 0.2;

/// Solids of revolution about y: a profile `(radius, y)` that goes round counter-clockwise with the axis on its left; a
/// profile that begins and ends on the axis is closed there, any other by the way back to its first point.
fn revolved(profile: &[DVec2], segments: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let rings: Vec<(u32, u32)> = profile
        .iter()
        .map(|p| {
            let first = mesh.positions.len() as u32;
            let count = if p.x == 0.0 { 1 } else { segments };
            for k in 0..count {
                let (sin, cos) = libm::sincos(2.0 * PI * f64::from(k) / f64::from(segments));
                mesh.positions.push(dvec3(p.x * cos, p.y, -p.x * sin));
            }
            (first, count)
        })
        .collect();
    let at = |(first, count): (u32, u32), k: u32| first + k % count;
    let closed = profile[0].x != 0.0;
    let pairs = (0..rings.len() - usize::from(!closed)).map(|i| (rings[i], rings[(i + 1) % rings.len()]));
    for (low, high) in pairs.collect::<Vec<_>>() {
        for k in 0..segments {
            let [a, b, c, d] = [at(low, k), at(low, k + 1), at(high, k + 1), at(high, k)];
            if a != b {
                mesh.triangles.push([a, b, c]);
            }
            if c != d {
                mesh.triangles.push([a, c, d]);
            }
        }
    }
    mesh
}

/// Points of a circle about `middle` from angle `from` to `to`, counted from straight down towards +x.
fn arc(middle: DVec2, radius: f64, from: f64, to: f64, steps: u32) -> impl Iterator<Item = DVec2> {
    (0..=steps).map(move |k| {
        let (sin, cos) = libm::sincos(from + (to - from) * f64::from(k) / f64::from(steps));
        middle + dvec2(sin, -cos) * radius
    })
}

/// A round bowl on a flat foot, 34 cm wide and 14 cm high, with a rounded rim.
fn bowl() -> Mesh {
    let (outer, inner) = (0.17, 0.163);
    let middle = dvec2(0.0, 0.165);
    let foot = libm::acos(middle.y / outer);
    let rim = 82.0 * PI / 180.0;
    let (sin, cos) = libm::sincos(rim);
    let edge = middle + dvec2(sin, -cos) * (0.5 * (outer + inner));
    let mut profile = vec![dvec2(0.0, 0.0)];
    profile.extend(arc(middle, outer, foot, rim, 28));
    // Half round the rim, without its ends.
    profile.extend(arc(edge, 0.5 * (outer - inner), rim, rim + PI, 8).skip(1).take(7));
    profile.extend(arc(middle, inner, rim, 0.0, 32));
    if let Some(last) = profile.last_mut() {
        last.x = 0.0;
    }
    revolved(&profile, 96)
}

/// A cut stone: a table, a girdle of eight corners, a point.
fn gem() -> Mesh {
    let profile = [(0.0, -0.016), (0.016, 0.002), (0.016, 0.004), (0.009, 0.01), (0.0, 0.01)];
    revolved(&profile.map(|(r, y)| dvec2(r, y)), 8)
}

/// A ring of round wire.
fn ring() -> Mesh {
    let wire: Vec<DVec2> = arc(dvec2(0.013, 0.0), 0.0042, -FRAC_PI_2, 1.5 * PI, 12).take(12).collect();
    revolved(&wire, 24)
}

pub fn bowl_ply_gz() -> Vec<u8> {
    bowl().ply_gz(QUANTUM)
}

pub fn gem_ply_gz() -> Vec<u8> {
    gem().ply_gz(QUANTUM)
}

pub fn ring_ply_gz() -> Vec<u8> {
    ring().ply_gz(QUANTUM)
}

/// Colours of what falls, by name.
const COLORS: [(&str, [f64; 3]); 8] = [
    ("coral", [0.8, 0.16, 0.11]),
    ("amber", [0.85, 0.45, 0.06]),
    ("lemon", [0.83, 0.7, 0.12]),
    ("leaf", [0.2, 0.5, 0.1]),
    ("sea", [0.04, 0.42, 0.42]),
    ("sky", [0.1, 0.3, 0.72]),
    ("plum", [0.32, 0.08, 0.36]),
    ("chalk", [0.8, 0.79, 0.75]),
];

/// The scene file.
pub fn scene() -> Vec<u8> {
    let mut text = HEAD.to_owned();
    for (name, [r, g, b]) in COLORS {
        // A String takes all that is written to it.
        let _ = write!(
            text,
            "\n[materials.{name}]\ntype = \"principled\"\nbase_color = [{r}, {g}, {b}]\nroughness = 0.25\n"
        );
    }
    let mut random = Random::new(9);
    for index in 0..BODIES {
        let place = place(index, &mut random);
        body(&mut text, index, place, &mut random);
    }
    text.into_bytes()
}

/// Where a body starts.
fn place(index: usize, random: &mut Random) -> [f64; 3] {
    let (layer, slot) = (index / LAYER, index % LAYER);
    let turn = 2.0 * PI * (slot as f64 / 6.0 + layer as f64 * 0.19);
    let (sin, cos) = libm::sincos(turn);
    let radius = if slot == 0 { 0.0 } else { 0.052 };
    let jitter = 0.004;
    [
        radius * cos + jitter * random.signed(),
        LOWEST + RISE * layer as f64 + jitter * random.signed(),
        radius * sin + jitter * random.signed(),
    ]
}

fn body(text: &mut String, index: usize, [x, y, z]: [f64; 3], random: &mut Random) {
    let size = 0.011 + 0.005 * random.unit();
    let (shape, scaled) = match index % 10 {
        0..4 => (format!("shape = \"sphere\"\nradius = {size:.4}"), ""),
        4..7 => {
            let edges = [0, 1, 2].map(|_| 1.25 * size * (0.8 + 0.4 * random.unit()));
            (format!("shape = \"box\"\nsize = [{:.4}, {:.4}, {:.4}]", edges[0], edges[1], edges[2]), "")
        }
        7 | 8 => ("mesh = \"gem\"".to_owned(), "{ scale = 0.00001 }, "),
        _ => ("mesh = \"ring\"".to_owned(), "{ scale = 0.00001 }, "),
    };
    let (color, _) = COLORS[(random.unit() * COLORS.len() as f64) as usize];
    let axis = direction(random);
    let angle = 360.0 * random.unit();
    let _ = write!(
        text,
        "\n[[objects]]\nname = \"body {}\"\n{shape}\nmaterial = \"{color}\"\nbody = {{ friction = 0.4, restitution = 0.3 }}\n\
         transform = [{scaled}{{ rotate = {{ axis = [{:.2}, {:.2}, {:.2}], angle = {angle:.1} }} }}, \
         {{ translate = [{x:.4}, {y:.4}, {z:.4}] }}]\n",
        index + 1,
        axis[0],
        axis[1],
        axis[2]
    );
}

/// Not of unit length, and not near zero.
fn direction(random: &mut Random) -> [f64; 3] {
    loop {
        let v = [random.signed(), random.signed(), random.signed()];
        if (0.25..1.0).contains(&v.iter().map(|c| c * c).sum()) {
            return v;
        }
    }
}

/// All but what falls.
const HEAD: &str = r#"# Balls, dice, cut stones and rings fall into a bowl of glass. A film: `etendue animate gallery/bowl.toml -o bowl.mp4`.
# Made by `cargo xtask gallery inputs`.

[camera]
position = [0.72, 0.4, 0.72]
look_at = [0, 0.11, 0]
fov = 27

[film]
size = [640, 360]
tonemap = "agx"

[sampler]
spp = 32

[integrator]
depth = 16

# One second and a quarter, at a quarter of its speed.
[animation]
fps = 25
speed = 0.25
frames = 130
shutter = [0, 0.5]

[physics]
gravity = [0, -9.81, 0]

[environment]
top = [0.45, 0.52, 0.62]
horizon = [0.75, 0.72, 0.68]
bottom = 0.1

[materials.table]
type = "principled"
base_color = [0.07, 0.1, 0.12]
roughness = 0.4

[materials.lamp]
type = "black"
emission = [7, 6.4, 5.6]

[materials.glass]
type = "glass"
ior = 1.5

[meshes.gem]
file = "inputs/gem.ply.gz"

[meshes.ring]
file = "inputs/ring.ply.gz"
crease_angle = 50

[[objects]]
name = "table"
shape = "rectangle"
corner = [-3, 0, 3]
u = [6, 0, 0]
v = [0, 0, -6]
material = "table"
body = { kind = "fixed", friction = 0.4 }

[[objects]]
name = "bowl"
file = "inputs/bowl.ply.gz"
crease_angle = 50
material = "glass"
body = { kind = "fixed", friction = 0.2 }
transform = [{ scale = 0.00001 }, { translate = [0, 0.0002, 0] }]

[[objects]]
name = "lamp"
shape = "disk"
radius = 0.8
material = "lamp"
transform = [{ look_at = { position = [-1.1, 1.5, 0.6], target = [0, 0.1, 0] } }]
"#;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solids_are_closed_and_the_right_way_out() {
        for (mesh, low, high) in [(bowl(), 4e-4, 1.2e-3), (gem(), 6e-6, 1e-5), (ring(), 4e-6, 5e-6)] {
            assert_eq!(mesh.open_edges(), 0);
            let volumes = mesh.solids();
            assert_eq!(volumes.len(), 1);
            assert!(volumes.values().all(|v| (low..high).contains(v)), "{volumes:?}");
        }
    }

    #[test]
    fn bodies_start_apart() {
        let mut random = Random::new(1);
        let places: Vec<[f64; 3]> = (0..BODIES).map(|i| place(i, &mut random)).collect();
        let reach = 0.0172;
        for (i, a) in places.iter().enumerate() {
            for b in &places[..i] {
                let square: f64 = (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c])).sum();
                assert!(square > 4.0 * reach * reach, "{a:?} {b:?}");
            }
        }
    }
}
