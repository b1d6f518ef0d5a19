//! Meshes that are written come back as they were.
#![allow(clippy::disallowed_methods, reason = "references are computed with the platform's functions")]

mod common;

use common::{check, obj_with};
use etendue::{
    material::{Color, Material, Number, Scattering},
    math::DVec3,
    scene::Mesh,
    spectrum::Spectrum,
    texture::{Mapping, Pattern, Texture},
};
use etendue_scene::{
    Diagnostics, SourceMap, Span,
    description::{ImageRecord, Located, TextureRecord},
    mesh_file::{self, Group, MeshFile, MeshLimits, NamedMaterial, Sphere},
    mesh_output::{MeshOutputFormat, write_mesh},
    output::{EncodeError, WriteError},
};
use proptest::{prelude::*, test_runner::RngSeed};
use std::{fs, path::Path};

/// Writes and reads back.
fn round_trip(folder: &Path, format: MeshOutputFormat, file: &MeshFile) -> MeshFile {
    let path = folder.join("a b").with_extension(format.ending());
    write_mesh(&path, format, file, folder).unwrap();
    read(&path)
}

fn read(path: &Path) -> MeshFile {
    let mut sources = SourceMap::new();
    let id = sources.read(path, 1 << 30).unwrap();
    let result = mesh_file::read(&mut sources, id, &MeshLimits::default());
    check(&result);
    result.unwrap_or_else(|found| panic!("{}", found.iter().map(|d| d.one_line(&sources) + "\n").collect::<String>()))
}

/// What corners of faces have, as bits: vertices may come in another order. Minus zero counts as zero.
fn corners(mesh: &Mesh) -> Vec<Vec<u32>> {
    let bits = |numbers: &[f32]| numbers.iter().map(|n| (n + 0.0).to_bits()).collect::<Vec<_>>();
    let corner = |&i: &u32| {
        let i = i as usize;
        let mut all = bits(&mesh.positions[i]);
        all.extend(mesh.normals.iter().flat_map(|n| bits(&n[i])));
        all.extend(mesh.uvs.iter().flat_map(|t| bits(&t[i])));
        all.extend(mesh.colors.iter().flat_map(|c| bits(&c[i])));
        all
    };
    mesh.indices.iter().flatten().map(corner).collect()
}

/// A colour of 8 bits for a position, the same for the same one.
fn colour(position: [f32; 3]) -> [f32; 4] {
    let [x, y, z] = position.map(|c| ((c + 0.0).to_bits() >> 11) as u8);
    let linear = |byte: u8| {
        let v = f64::from(byte) / 255.0;
        (if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }) as f32
    };
    [linear(x), linear(y), linear(z), if x > 127 { 1.0 } else { f32::from(y) / 255.0 }]
}

fn mesh() -> impl Strategy<Value = Mesh> {
    let number = || {
        prop_oneof![
            -10.0f32..10.0,
            (-2i8..3).prop_map(f32::from),
            any::<f32>().prop_filter("in range", |v| v.abs() < 1e17)
        ]
    };
    let normal = (-1.0f64..1.0, -1.0f64..1.0, 0.1f64..1.0)
        .prop_map(|(x, y, z)| DVec3::new(x, y, z).normalize().as_vec3().to_array());
    let vertices = prop::collection::vec(([number(), number(), number()], normal, [number(), number()]), 3..20);
    (vertices, any::<[bool; 3]>()).prop_flat_map(|(vertices, [normals, uvs, colors])| {
        let count = vertices.len() as u32;
        let face = (0..count, 0..count - 1, 0..count - 2).prop_map(move |(a, i, j)| {
            let b = (a + 1 + i) % count;
            [a, b, (a + 1 + (i + 1 + j) % (count - 1)) % count]
        });
        prop::collection::vec(face, 1..30).prop_map(move |indices| Mesh {
            origin: DVec3::ZERO,
            positions: vertices.iter().map(|v| v.0).collect(),
            indices: indices.into(),
            normals: normals.then(|| vertices.iter().map(|v| v.1).collect()),
            uvs: uvs.then(|| vertices.iter().map(|v| v.2).collect()),
            colors: colors.then(|| vertices.iter().map(|v| colour(v.0)).collect()),
            face_materials: None,
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 120, rng_seed: RngSeed::Fixed(7), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_comes_back_to_the_bit(mesh in mesh()) {
        let folder = tempfile::tempdir().unwrap();
        // As a reader gives it: with a local origin where the mesh lies far from the file's.
        let file = round_trip(folder.path(), MeshOutputFormat::Ply, &MeshFile::of_mesh(mesh, Diagnostics::new()));
        prop_assume!(file.mesh.origin == DVec3::ZERO);
        for format in [MeshOutputFormat::Obj, MeshOutputFormat::Ply] {
            let back = round_trip(folder.path(), format, &file);
            prop_assert_eq!(back.mesh.origin, DVec3::ZERO);
            prop_assert_eq!(corners(&back.mesh), corners(&file.mesh), "{:?}", format);
        }
        // STL keeps positions alone, and drops faces whose corners have become one.
        let flat = Mesh { normals: None, uvs: None, colors: None, ..file.mesh.clone() };
        let different = |face: &&[u32; 3]| {
            let [a, b, c] = face.map(|i| flat.positions[i as usize]);
            a != b && b != c && c != a
        };
        let kept = Mesh { indices: flat.indices.iter().filter(different).copied().collect(), ..flat.clone() };
        let back = round_trip(folder.path(), MeshOutputFormat::Stl, &file);
        if back.mesh.origin == DVec3::ZERO {
            prop_assert_eq!(corners(&back.mesh), corners(&kept));
        }
    }
}

#[test]
fn meshes_far_away_keep_their_detail() {
    let folder = tempfile::tempdir().unwrap();
    let positions = [[0.0, 0.0, 0.0], [1e-4, 0.0, 0.0], [0.0, 1e-4, 0.25], [1e-4, 1e-4, 0.0]];
    let mesh = Mesh {
        origin: DVec3::new(10_000.0, 0.0, -12_345.5),
        positions: positions.into(),
        indices: [[0, 1, 2], [1, 3, 2]].into(),
        normals: None,
        uvs: None,
        colors: None,
        face_materials: None,
    };
    let file = MeshFile::of_mesh(mesh, Diagnostics::new());
    let world = |mesh: &Mesh| -> Vec<DVec3> {
        let corners = mesh.indices.iter().flatten();
        corners.map(|&i| mesh.origin + DVec3::from(mesh.positions[i as usize].map(f64::from))).collect()
    };
    for format in [MeshOutputFormat::Obj, MeshOutputFormat::Ply] {
        let back = round_trip(folder.path(), format, &file);
        for (a, b) in world(&back.mesh).iter().zip(world(&file.mesh)) {
            assert!((*a - b).abs().max_element() < 1e-8, "{format:?}: {a} {b}");
        }
    }
    // 32 bits have a step of 0.001 there.
    let back = round_trip(folder.path(), MeshOutputFormat::Stl, &file);
    assert!(world(&back.mesh).iter().all(|p| (*p - DVec3::new(1e4, 0.0, -12_345.5)).length() < 0.3));
}

#[test]
fn seams_share_their_positions() {
    let folder = tempfile::tempdir().unwrap();
    let cube = obj_with("vn 0 0 1\nvn 1 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1//1 2//1 3//1\nf 1//2 3//2 4//2\n");
    assert_eq!(cube.mesh.positions.len(), 6);
    let path = folder.path().join("a.obj");
    write_mesh(&path, MeshOutputFormat::Obj, &cube, folder.path()).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(text.lines().filter(|line| line.starts_with("v ")).count(), 4, "{text}");
    assert_eq!(corners(&read(&path).mesh), corners(&cube.mesh));
}

fn materials() -> Vec<Material<TextureRecord>> {
    let grey = |v: f32| Spectrum([v, 0.5 * v, 0.25 * v]);
    let named = |name: &str, scattering| Material::new(name, scattering);
    let mut glowing = named("", Scattering::Diffuse { reflectance: grey(0.3), transmittance: Spectrum::BLACK });
    glowing.emission =
        Some(etendue::material::Emission { radiance: Color::from(Spectrum([17.0, 12.0, 4.0])), two_sided: true });
    glowing.opacity = Number::from(0.25);
    vec![
        named("clay # 1", Scattering::Diffuse { reflectance: grey(0.8), transmittance: Spectrum::BLACK }),
        glowing,
        named("mirror", Scattering::Mirror { reflectance: grey(0.9) }),
        named(
            "glass",
            Scattering::Glass { ior: 1.33, reflection_tint: Spectrum::ONE, transmission_tint: grey(0.7), thin: false },
        ),
        named("black", Scattering::Black),
        named(
            "mixed",
            Scattering::Mtl {
                diffuse: grey(0.5),
                specular: grey(0.2),
                alpha: 0.125,
                transmission: Spectrum::BLACK,
                ior: 1.5,
            },
        ),
        named("clay # 1", Scattering::Mirror { reflectance: grey(0.1) }),
    ]
}

#[test]
fn materials_groups_and_spheres_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let materials: Vec<NamedMaterial> = materials()
        .into_iter()
        .map(|material| NamedMaterial { name: material.name.clone(), material: Box::new(material), origin: None })
        .collect();
    let count = materials.len() as u32;
    let positions: Vec<[f32; 3]> = (0..count + 2).map(|i| [i as f32, (i * i) as f32, 0.0]).collect();
    let group = |object: Option<&str>, group: Option<&str>, faces| Group {
        object: object.map(str::to_owned),
        group: group.map(str::to_owned),
        faces,
    };
    let mesh = Mesh {
        origin: DVec3::ZERO,
        positions: positions.into(),
        indices: (0..count).map(|i| [i, i + 1, i + 2]).collect(),
        normals: None,
        uvs: None,
        colors: None,
        face_materials: Some((0..count).collect()),
    };
    let spheres = vec![
        Sphere { center: DVec3::new(0.1, 2.0, -3.0), radius: 0.3, material: 2 },
        Sphere { center: DVec3::ZERO, radius: 1e-3, material: 0 },
    ];
    let groups = vec![
        group(Some("a b"), None, 0..2),
        group(Some("a b"), Some("left leg"), 2..3),
        group(Some("c"), None, 3..5),
        group(Some("c"), Some("d"), 5..7),
    ];
    let file = MeshFile { spheres, materials, groups, ..MeshFile::of_mesh(mesh, Diagnostics::new()) };
    let back = round_trip(folder.path(), MeshOutputFormat::Obj, &file);
    assert_eq!(back.groups, file.groups);
    assert_eq!(back.spheres, file.spheres);
    assert_eq!(back.mesh.face_materials, file.mesh.face_materials);
    let names: Vec<&str> = back.materials.iter().map(|m| &m.name[..]).collect();
    assert_eq!(names, ["clay # 1", "unnamed", "mirror", "glass", "black", "mixed", "clay # 1 2"]);
    for (back, material) in back.materials.iter().zip(&file.materials) {
        let (back, material) = (&back.material, &material.material);
        assert_eq!((&back.emission, &back.opacity), (&material.emission, &material.opacity));
        match (&back.scattering, &material.scattering) {
            (Scattering::Mtl { alpha: a, diffuse: d, .. }, Scattering::Mtl { alpha: b, diffuse: e, .. }) => {
                assert!((a.factor - b.factor).abs() < 1e-6 && d == e);
            }
            (a, b) => assert_eq!(a, b),
        }
    }
    let written: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(written.len(), 2, "{written:?}");
}

#[test]
fn faces_without_a_name_stay_out_of_the_group_before() {
    let folder = tempfile::tempdir().unwrap();
    let file = obj_with("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\ng a\nf 2 3 1\ng\nf 3 2 1\nf 1 3 2\ng b\nf 2 1 3\n");
    assert_eq!(file.groups.len(), 2);
    assert_eq!(round_trip(folder.path(), MeshOutputFormat::Obj, &file).groups, file.groups);
    let mut file = file;
    file.groups = vec![Group { object: Some("c".to_owned()), group: None, faces: 1..2 }];
    let back = round_trip(folder.path(), MeshOutputFormat::Obj, &file);
    let names: Vec<_> = back.groups.iter().map(|g| (g.object.as_deref(), g.faces.clone())).collect();
    assert_eq!(names, [(Some("c"), 1..2), (Some("unnamed"), 2..5)]);
}

#[test]
fn textures_are_named_from_the_new_place() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("out")).unwrap();
    let origin = Span::new(SourceMap::new().insert("x", vec![]).unwrap(), 0..0).into();
    let texture = Texture {
        pattern: Pattern::Image(ImageRecord {
            file: Located { value: "maps/wood 1.png".into(), origin },
            transfer: None,
        }),
        mapping: Mapping::default(),
    };
    let white = Scattering::Diffuse { reflectance: Spectrum::ONE, transmittance: Spectrum::BLACK };
    let mut material = Material::new("wood", white);
    material.scattering = Scattering::Diffuse {
        reflectance: Color { factor: Spectrum::ONE, texture: Some(std::sync::Arc::new(texture)) },
        transmittance: Spectrum::BLACK.into(),
    };
    let mut file = obj_with("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    file.materials = vec![NamedMaterial { name: "wood".to_owned(), material: Box::new(material), origin: None }];
    let path = folder.path().join("out/a.obj");
    write_mesh(&path, MeshOutputFormat::Obj, &file, folder.path()).unwrap();
    let library = fs::read_to_string(path.with_extension("mtl")).unwrap();
    assert!(library.contains("newmtl wood\nKd 1 1 1\nmap_Kd ../maps/wood 1.png\n"), "{library}");
    assert!(fs::read_to_string(&path).unwrap().contains("mtllib a.mtl\n"));
}

#[test]
fn meshes_that_contradict_themselves_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let good = obj_with("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let with = |change: &dyn Fn(&mut Mesh)| {
        let mut file = good.clone();
        change(&mut file.mesh);
        file
    };
    for bad in [
        with(&|mesh| mesh.indices = [[0, 1, 3]].into()),
        with(&|mesh| mesh.normals = Some([[0.0, 0.0, 1.0]].into())),
        with(&|mesh| mesh.uvs = Some([[0.0; 2]; 4].into())),
        with(&|mesh| mesh.face_materials = Some([1].into())),
    ] {
        for format in MeshOutputFormat::ALL {
            let path = folder.path().join("a").with_extension(format.ending());
            let error = write_mesh(&path, format, &bad, folder.path()).unwrap_err();
            assert!(matches!(error, WriteError::Encode { source: EncodeError::Malformed(_), .. }), "{error}");
        }
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    assert_eq!(MeshOutputFormat::of_path(Path::new("a.b.OBJ")), Some(MeshOutputFormat::Obj));
    assert_eq!(MeshOutputFormat::of_path(Path::new("a.off")), None);
}
