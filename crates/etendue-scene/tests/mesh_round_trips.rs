//! Meshes written in every form come back as they were.
#![allow(clippy::disallowed_methods)]

mod common;

use common::{check, read_obj, read_ply};
use etendue::scene::Mesh;
use proptest::{prelude::*, test_runner::RngSeed};
use std::fmt::Write;

/// Positions, texture coordinates, normals, and triangles of (position, uv, normal) triples.
#[derive(Clone, Debug)]
struct Model {
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    faces: Vec<[[usize; 3]; 3]>,
}

fn model() -> impl Strategy<Value = Model> {
    let number =
        || prop_oneof![-10.0f32..10.0, (-4i8..5).prop_map(f32::from), any::<i16>().prop_map(|i| f32::from(i) * 1e-3)];
    let unit = (-1.0f32..1.0, -1.0f32..1.0, 0.1f32..1.0).prop_map(|(x, y, z)| {
        let (x, y, z) = (f64::from(x), f64::from(y), f64::from(z));
        let length = (x * x + y * y + z * z).sqrt();
        [(x / length) as f32, (y / length) as f32, (z / length) as f32]
    });
    let lists = (
        prop::collection::vec([number(), number(), number()], 3..20),
        prop::collection::vec([number(), number()], 1..8),
        prop::collection::vec(unit, 1..8),
    );
    lists.prop_flat_map(|(positions, uvs, normals)| {
        let count = positions.len();
        let attributes = || (0..uvs.len(), 0..normals.len());
        // Three different positions.
        let face = (0..count, 0..count - 1, 0..count - 2, [attributes(), attributes(), attributes()]).prop_map(
            move |(a, i, j, attributes)| {
                let b = (a + 1 + i) % count;
                let c = (a + 1 + (i + 1 + j) % (count - 1)) % count;
                let mut positions = [a, b, c].into_iter();
                attributes.map(|(t, n)| [positions.next().unwrap(), t, n])
            },
        );
        (Just(positions), Just(uvs), Just(normals), prop::collection::vec(face, 1..30))
            .prop_map(|(positions, uvs, normals, faces)| Model { positions, uvs, normals, faces })
    })
}

#[derive(Clone, Copy, Debug)]
struct Form {
    uvs: bool,
    normals: bool,
    relative: bool,
    /// CRLF, tabs, continued lines.
    ugly: bool,
    /// Faces before what they name; not for relative indices.
    faces_first: bool,
}

fn obj(model: &Model, form: Form) -> String {
    let (mut vertices, mut faces) = (String::new(), String::new());
    for [x, y, z] in &model.positions {
        writeln!(vertices, "v {x} {y} {z:e}").unwrap();
    }
    for [u, v] in &model.uvs {
        writeln!(vertices, "vt {u} {v}").unwrap();
    }
    for [x, y, z] in &model.normals {
        writeln!(vertices, "vn {x} {y} {z}").unwrap();
    }
    let counts = [model.positions.len(), model.uvs.len(), model.normals.len()];
    for face in &model.faces {
        faces.push('f');
        for corner in face {
            let index = |k: usize| match form.relative {
                true => corner[k] as i64 - counts[k] as i64,
                false => corner[k] as i64 + 1,
            };
            let text = match (form.uvs, form.normals) {
                (false, false) => format!(" {}", index(0)),
                (true, false) => format!(" {}/{}", index(0), index(1)),
                (false, true) => format!(" {}//{}", index(0), index(2)),
                (true, true) => format!(" {}/{}/{}", index(0), index(1), index(2)),
            };
            faces += &text;
        }
        faces.push('\n');
    }
    let text = if form.faces_first && !form.relative { faces + &vertices } else { vertices + &faces };
    if !form.ugly {
        return text;
    }
    format!("\u{feff}{}", text.replace(' ', " \t \\\r\n ").trim_end().replace("\nf", "\n\n  # x\r\n\tf"))
}

fn assert_same(model: &Model, mesh: &Mesh, form: Form) {
    assert_eq!(mesh.indices.len(), model.faces.len());
    assert_eq!((mesh.uvs.is_some(), mesh.normals.is_some()), (form.uvs, form.normals));
    let mut seen = std::collections::BTreeMap::new();
    for (face, indices) in model.faces.iter().zip(mesh.indices.iter()) {
        for (&[p, t, n], &vertex) in face.iter().zip(indices) {
            let i = vertex as usize;
            for axis in 0..3 {
                let expected = f64::from(model.positions[p][axis]) - mesh.origin[axis];
                assert_eq!(mesh.positions[i][axis].to_bits(), (expected as f32).to_bits());
            }
            if let Some(uvs) = &mesh.uvs {
                assert_eq!(uvs[i], model.uvs[t]);
            }
            if let Some(normals) = &mesh.normals {
                assert!((0..3).all(|axis| (normals[i][axis] - model.normals[n][axis]).abs() < 1e-6));
            }
            // Equal corners are one vertex, different ones are not, and numbers go by first use.
            let key = [p, if form.uvs { t } else { 0 }, if form.normals { n } else { 0 }];
            let next = seen.len() as u32;
            assert_eq!(*seen.entry(key).or_insert(next), vertex);
        }
    }
    assert_eq!(seen.len(), mesh.positions.len());
}

fn ply_header(format: &str, model: &Model, scalar: &str, extra: bool) -> String {
    let list = if extra {
        "property uint8 flags\nproperty list uchar uint vertex_index\n"
    } else {
        "property list int ushort vertex_indices\n"
    };
    format!(
        "ply\nformat {format} 1.0\ncomment x\nelement vertex {}\nproperty {scalar} x\nproperty {scalar} y\n\
         property {scalar} z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float s\n\
         property float t\nelement junk 2\nproperty list char short a\nelement face {}\n{list}end_header\n",
        model.positions.len(),
        model.faces.len(),
    )
}

/// The same values as text and as bytes, little or big endian.
fn ply(model: &Model, format: &str, double: bool, extra: bool) -> Vec<u8> {
    let mut out = ply_header(format, model, if double { "double" } else { "float32" }, extra).into_bytes();
    let text = format == "ascii";
    let big = format == "binary_big_endian";
    let number = |out: &mut Vec<u8>, value: f64, bytes: Vec<u8>| {
        if text {
            out.extend(format!("{value} ").bytes());
        } else if big {
            out.extend(bytes.into_iter().rev());
        } else {
            out.extend(bytes);
        }
    };
    let f32_of = |out: &mut Vec<u8>, value: f32| number(out, f64::from(value), value.to_le_bytes().to_vec());
    let end = |out: &mut Vec<u8>| {
        if text {
            out.push(b'\n');
        }
    };
    for (i, position) in model.positions.iter().enumerate() {
        for &c in position {
            if double {
                number(&mut out, f64::from(c), f64::from(c).to_le_bytes().to_vec())
            } else {
                f32_of(&mut out, c)
            }
        }
        let (normal, uv) = (model.normals[i % model.normals.len()], model.uvs[i % model.uvs.len()]);
        normal.into_iter().chain(uv).for_each(|c| f32_of(&mut out, c));
        end(&mut out);
    }
    for _ in 0..2 {
        number(&mut out, 2.0, vec![2]);
        number(&mut out, -1.0, (-1i16).to_le_bytes().to_vec());
        number(&mut out, 7.0, 7i16.to_le_bytes().to_vec());
        end(&mut out);
    }
    for face in &model.faces {
        if extra {
            number(&mut out, 9.0, vec![9]);
            number(&mut out, 3.0, vec![3]);
        } else {
            number(&mut out, 3.0, 3i32.to_le_bytes().to_vec());
        }
        for corner in face {
            let bytes = if extra {
                (corner[0] as u32).to_le_bytes().to_vec()
            } else {
                (corner[0] as u16).to_le_bytes().to_vec()
            };
            number(&mut out, corner[0] as f64, bytes);
        }
        end(&mut out);
    }
    out
}

fn bits(mesh: &Mesh) -> (Vec<u64>, Vec<u32>, Vec<[u32; 3]>) {
    let floats = mesh.positions.iter().flatten().chain(mesh.normals.iter().flat_map(|n| n.iter().flatten()));
    let floats = floats.chain(mesh.uvs.iter().flat_map(|t| t.iter().flatten())).map(|c| c.to_bits()).collect();
    (mesh.origin.to_array().map(f64::to_bits).to_vec(), floats, mesh.indices.to_vec())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn obj_in_every_form(model in model()) {
        for number in 0..32 {
            let flag = |bit: u32| number >> bit & 1 == 1;
            let form = Form { uvs: flag(0), normals: flag(1), relative: flag(2), ugly: flag(3), faces_first: flag(4) };
            let text = obj(&model, form);
            let result = read_obj(text.as_bytes(), b"");
            check(&result);
            let file = result.unwrap_or_else(|found| panic!("{form:?}\n{text}\n{found:?}"));
            prop_assert!(file.notes.is_empty(), "{:?}", file.notes);
            assert_same(&model, &file.mesh, form);
        }
    }

    #[test]
    fn ply_in_every_encoding_gives_the_same_bits(model in model()) {
        let mut first = None;
        for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
            for (double, extra) in [(false, false), (true, true)] {
                let result = read_ply(&ply(&model, format, double, extra));
                check(&result);
                let file = result.unwrap_or_else(|found| panic!("{format} {found:?}"));
                let bits = bits(&file.mesh);
                prop_assert_eq!(first.get_or_insert_with(|| bits.clone()), &bits, "{} {}", format, double);
                let mesh = &file.mesh;
                prop_assert_eq!(mesh.indices.len(), model.faces.len());
                for (face, indices) in model.faces.iter().zip(mesh.indices.iter()) {
                    for (corner, &i) in face.iter().zip(indices) {
                        let there = glam::DVec3::from(mesh.positions[i as usize].map(f64::from)) + mesh.origin;
                        let wanted = glam::DVec3::from(model.positions[corner[0]].map(f64::from));
                        prop_assert!((there - wanted).abs().max_element() <= 1e-6);
                        prop_assert_eq!(mesh.uvs.as_ref().unwrap()[i as usize], model.uvs[corner[0] % model.uvs.len()]);
                    }
                }
            }
        }
    }

    /// Vertices of a seam have the same position by bits, however many normals and texture coordinates meet there.
    #[test]
    fn seams_stay_closed(model in model()) {
        let form = Form { uvs: true, normals: true, relative: false, ugly: false, faces_first: false };
        let mesh = read_obj(obj(&model, form).as_bytes(), b"").unwrap().mesh;
        let mut known = vec![None; model.positions.len()];
        for (face, indices) in model.faces.iter().zip(mesh.indices.iter()) {
            for (corner, &i) in face.iter().zip(indices) {
                let bits = mesh.positions[i as usize].map(f32::to_bits);
                prop_assert_eq!(*known[corner[0]].get_or_insert(bits), bits);
            }
        }
    }
}
