//! What simplified models look like: sharp edges stay where they are, and textures stay on the surface.
#![allow(clippy::disallowed_methods, reason = "tests are not compared bit by bit")]

mod common;

use common::Folder;
use etendue::{
    image::{Channel, ChannelData, Image},
    math::DVec3,
};
use etendue_scene::output::{Format, Metadata, write_image};
use std::{collections::BTreeMap, f64::consts::TAU, fmt::Write, fs, path::Path};

/// Positions and triangles of a written OBJ file.
struct Model {
    positions: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
}

impl Model {
    fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap();
        let rows = |key: &'static str| text.lines().filter_map(move |line| line.strip_prefix(key));
        let point = |row: &str| {
            let numbers: Vec<f64> = row.split_whitespace().map(|n| n.parse().unwrap()).collect();
            DVec3::new(numbers[0], numbers[1], numbers[2])
        };
        let corner = |word: &str| word.split('/').next().unwrap().parse::<usize>().unwrap() - 1;
        let triangle = |row: &str| {
            let corners: Vec<usize> = row.split_whitespace().map(corner).collect();
            [corners[0], corners[1], corners[2]]
        };
        Self { positions: rows("v ").map(point).collect(), triangles: rows("f ").map(triangle).collect() }
    }

    fn diagonal(&self) -> f64 {
        let low = self.positions.iter().copied().reduce(DVec3::min).unwrap();
        let high = self.positions.iter().copied().reduce(DVec3::max).unwrap();
        (high - low).length()
    }

    /// Edges whose two faces differ by more than 40 degrees in direction.
    fn creases(&self) -> Vec<[DVec3; 2]> {
        let mut normals: BTreeMap<[usize; 2], Vec<DVec3>> = BTreeMap::new();
        for &[a, b, c] in &self.triangles {
            let [p, q, r] = [a, b, c].map(|i| self.positions[i]);
            let normal = (q - p).cross(r - p).normalize();
            for (i, j) in [(a, b), (b, c), (c, a)] {
                normals.entry([i.min(j), i.max(j)]).or_default().push(normal);
            }
        }
        assert!(normals.values().all(|n| n.len() == 2), "the surface is closed");
        let cosine = 40f64.to_radians().cos();
        let sharp = normals.into_iter().filter(|(_, n)| n[0].dot(n[1]) < cosine);
        sharp.map(|([i, j], _)| [self.positions[i], self.positions[j]]).collect()
    }
}

fn distance_to(segment: [DVec3; 2], p: DVec3) -> f64 {
    let [a, b] = segment;
    let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a + (b - a) * t)
}

/// Of points all along the creases of one model, the farthest from the creases of the other.
fn farthest(from: &[[DVec3; 2]], to: &[[DVec3; 2]]) -> f64 {
    let points = from.iter().flat_map(|[a, b]| [0.0, 0.25, 0.5, 0.75, 1.0].map(|t| *a + (*b - *a) * t));
    points.map(|p| to.iter().map(|s| distance_to(*s, p)).fold(f64::INFINITY, f64::min)).fold(0.0, f64::max)
}

#[test]
fn creases_of_a_block_of_flat_faces() {
    let folder = Folder::new();
    let block = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../gallery/inputs/block.ply.gz");
    fs::copy(block, folder.path("block.ply.gz")).unwrap();
    folder.run("convert block.ply.gz block.obj").with_code(0);
    let json = folder.run("simplify block.ply.gz -o small.obj --faces 200 --json --require-target").with_code(0).json();
    assert_eq!((&json["faces_in"], &json["faces_out"]), (&4268.into(), &200.into()));
    let (block, small) = (Model::read(&folder.path("block.obj")), Model::read(&folder.path("small.obj")));
    let limit = 1e-3 * block.diagonal();
    let (before, after) = (block.creases(), small.creases());
    assert!(before.len() > 400 && after.len() < before.len() / 3, "{} {}", before.len(), after.len());
    let (forth, back) = (farthest(&before, &after), farthest(&after, &before));
    assert!(forth <= limit && back <= limit, "creases are off by {forth} and {back}, at most {limit}");
}

/// A bumpy ring with texture coordinates that repeat nowhere, and smooth normals.
fn ring() -> String {
    let (around, across) = (128usize, 64usize);
    let mut text = String::from("mtllib ring.mtl\nusemtl painted\ns 1\n");
    let turn = |i: usize, n: usize| TAU * i as f64 / n as f64;
    for i in 0..around {
        for k in 0..across {
            let (a, b) = (turn(i, around), turn(k, across));
            let r = 0.45 + 0.03 * (5.0 * a).sin() * (3.0 * b).cos();
            let out = 1.0 + r * b.cos();
            let _ = writeln!(text, "v {} {} {}", out * a.cos(), r * b.sin(), -out * a.sin());
        }
    }
    for i in 0..=around {
        for k in 0..=across {
            let _ = writeln!(text, "vt {} {}", i as f64 / around as f64, k as f64 / across as f64);
        }
    }
    for i in 0..around {
        for k in 0..across {
            let corner =
                |i: usize, k: usize| format!("{}/{}", i % around * across + k % across + 1, i * (across + 1) + k + 1);
            let corners = [corner(i, k), corner(i + 1, k), corner(i + 1, k + 1), corner(i, k + 1)];
            let _ = writeln!(text, "f {}", corners.join(" "));
        }
    }
    text
}

/// Fields of colour with lines between, so that whatever slips shows.
fn painting() -> Image {
    let (width, height) = (256u32, 128u32);
    let colour = |x: u32, y: u32, channel: usize| {
        let field = (x / 16 * 7 + y / 16 * 3) as usize;
        let line = x.is_multiple_of(16) || y.is_multiple_of(16);
        if line { 0.05 } else { [0.15f32, 0.45, 0.8][(field + channel * field / 3) % 3] }
    };
    let channel = |(number, name): (usize, &str)| {
        let data = (0..width * height).map(|i| colour(i % width, i / width, number)).collect();
        Channel { name: name.to_owned(), data: ChannelData::F32(data) }
    };
    Image { width, height, channels: ["R", "G", "B"].into_iter().enumerate().map(channel).collect() }
}

fn scene(model: &str, position: [f64; 3]) -> String {
    format!(
        "[camera]\nposition = {position:?}\nlook_at = [0, 0, 0]\nfov = 40\n[film]\nsize = [64, 64]\nfilter = \"box\"\n\
         [sampler]\nspp = 256\nseed = 1\n[integrator]\ndepth = 4\n[environment]\ntop = [1.0, 1.0, 1.0]\nbottom = 0.2\n\
         [[objects]]\nfile = \"{model}\"\n"
    )
}

#[test]
fn a_textured_model_at_a_quarter_of_its_faces_looks_the_same() {
    let folder = Folder::new();
    folder.put("ring.obj", ring());
    folder.put("ring.mtl", "newmtl painted\nKd 1 1 1\nmap_Kd painting.png\n");
    let encode = |rgb: [f32; 3]| rgb.map(|c| (c * 255.0).round() as u8);
    write_image(&folder.path("painting.png"), Format::Png, &painting(), &Metadata::default(), &encode).unwrap();
    let json = folder.run("simplify ring.obj -o quarter.obj --ratio 0.25 --json").with_code(0).json();
    assert_eq!((&json["faces_in"], &json["faces_out"]), (&16384.into(), &4096.into()));
    let mut sum = 0.0;
    for (i, position) in [[3.0, 2.0, 2.0], [-0.5, 3.8, 1.0], [-3.2, 0.6, -2.0]].into_iter().enumerate() {
        for (name, model) in [("whole", "ring.obj"), ("quarter", "quarter.obj")] {
            folder.put("view.toml", scene(model, position));
            folder.run(&format!("render view.toml --quiet -o {name}-{i}.png")).with_code(0);
        }
        let words = format!("diff quarter-{i}.png whole-{i}.png --metric flip --json");
        sum += folder.run(&words).with_code(0).json()["value"].as_f64().unwrap();
    }
    assert!(sum / 3.0 < 0.05, "mean FLIP {}", sum / 3.0);
}
