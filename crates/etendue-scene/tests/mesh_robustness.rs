//! Whatever the bytes, a reader ends with a sound mesh or with reasons.

mod common;

use common::{check, read_obj, read_off, read_ply, read_stl};
use etendue_scene::{SourceMap, mtl};
use proptest::{prelude::*, test_runner::RngSeed};
use std::sync::LazyLock;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data");

/// The small files of the tests, and some made here.
static SEEDS: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let folders = ["meshes", "obj"].map(|folder| std::fs::read_dir(format!("{DATA}/{folder}")).unwrap());
    let entries = folders.into_iter().flatten().map(|entry| entry.unwrap().path());
    let mut paths: Vec<_> = entries.filter(|p| p.is_file() && !p.ends_with("expected.txt")).collect();
    paths.sort();
    let mut seeds: Vec<Vec<u8>> = paths.iter().map(|path| std::fs::read(path).unwrap()).collect();
    seeds.push(b"ply\nformat binary_big_endian 1.0\nelement vertex 2\nproperty double x\nproperty double y\nproperty double z\nelement face 2\nproperty list uchar uchar vertex_index\nend_header\n".iter().copied().chain([0; 48]).chain([3, 0, 1, 0, 4, 1, 0, 1, 0]).collect());
    seeds
});

fn read_all(bytes: &[u8]) {
    check(&read_obj(bytes, bytes));
    check(&read_obj(b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n", bytes));
    check(&read_ply(bytes));
    check(&read_stl(bytes));
    check(&read_off(bytes));
    let file = SourceMap::new().insert("m.mtl", vec![]).unwrap();
    let _ = mtl::read(bytes, file);
}

fn number() -> impl Strategy<Value = String> {
    prop_oneof![
        4 => any::<i8>().prop_map(|i| i.to_string()),
        2 => (-2.0f64..2.0).prop_map(|x| x.to_string()),
        1 => any::<f64>().prop_map(|x| format!("{x:e}")),
        1 => prop::sample::select(vec!["nan", "inf", "-1e999", "1e30", "1,5", "-", ".", "1e", "4294967296", "99999999999999999999", "\u{e9}"])
            .prop_map(str::to_owned),
    ]
}

fn corner() -> impl Strategy<Value = String> {
    prop_oneof![
        8 => (1u8..9).prop_map(|i| i.to_string()),
        4 => (-8i8..9, -3i8..4, -3i8..4).prop_map(|(a, b, c)| format!("{a}/{b}/{c}")),
        2 => (1u8..9, 1u8..3).prop_map(|(a, b)| format!("{a}//{b}")),
        1 => number(),
    ]
}

fn line(words: Vec<&'static str>, value: impl Strategy<Value = String>, most: usize) -> impl Strategy<Value = String> {
    (prop::sample::select(words), prop::collection::vec(value, 0..most), "[ \t]{1,2}|[ ]\\\\\n", "\r?\n|\r| #\n")
        .prop_map(|(word, values, blank, end)| format!("{word}{blank}{}{end}", values.join(&blank)))
}

fn obj_text() -> impl Strategy<Value = String> {
    let name =
        || prop::sample::select(vec!["a", "b c", "m.mtl", "x.mtl m.mtl", "", "1", "off", "#"]).prop_map(str::to_owned);
    let lines = prop_oneof![
        6 => line(vec!["v", "vt", "vn"], number(), 5),
        6 => line(vec!["f"], corner(), 7),
        2 => line(vec!["usemtl", "mtllib", "o", "g", "s"], name(), 2),
        1 => line(vec!["sphere"], number(), 5),
        1 => line(vec!["l", "p", "vp", "cstype", "foo", ""], number(), 4),
    ];
    prop::collection::vec(lines, 0..30)
        .prop_map(|lines| format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\nvt 0 0\nvn 0 0 1\n{}", lines.concat()))
}

fn mtl_text() -> impl Strategy<Value = String> {
    let keys = vec![
        "Kd",
        "Ks",
        "Ke",
        "Ka",
        "Tf",
        "Ns",
        "Ni",
        "d",
        "Tr",
        "illum",
        "newmtl",
        "map_Kd",
        "Kd spectral",
        "d -halo",
        "Pr",
        "foo",
    ];
    prop::collection::vec(line(keys, number(), 5), 0..20).prop_map(|lines| format!("newmtl a\n{}", lines.concat()))
}

fn ply_bytes() -> impl Strategy<Value = Vec<u8>> {
    let kind =
        || prop::sample::select(vec!["char", "uchar", "int16", "ushort", "int", "uint32", "float", "double", "what"]);
    let name =
        || prop::sample::select(vec!["x", "y", "z", "nx", "ny", "nz", "u", "v", "s", "t", "red", "vertex_index", "q"]);
    let property = prop_oneof![
        3 => (kind(), name()).prop_map(|(k, n)| format!("property {k} {n}\n")),
        1 => (kind(), kind(), name()).prop_map(|(a, b, n)| format!("property list {a} {b} {n}\n")),
        1 => Just("property float x\nproperty float y\nproperty float z\n".to_owned()),
        1 => Just("property list uchar uchar vertex_indices\n".to_owned()),
    ];
    let count = prop_oneof![8 => 0u64..6, 1 => any::<u64>(), 1 => any::<u32>().prop_map(u64::from)];
    let element = (
        prop::sample::select(vec!["vertex", "face", "tristrips", "edge"]),
        count,
        prop::collection::vec(property, 0..5),
    )
        .prop_map(|(name, count, properties)| format!("element {name} {count}\n{}", properties.concat()));
    let header = (
        prop::sample::select(vec!["ascii", "binary_little_endian", "binary_big_endian"]),
        prop::collection::vec(element, 0..4),
    );
    let text = prop::collection::vec(
        prop_oneof![4 => (0u8..5).prop_map(|i| i.to_string()), 1 => number(), 2 => Just("\n".to_owned())],
        0..80,
    );
    let data = prop_oneof![
        prop::collection::vec(0u8..5, 0..200),
        prop::collection::vec(any::<u8>(), 0..200),
        text.prop_map(|words| words.join(" ").into_bytes()),
    ];
    (header, data).prop_map(|((format, elements), data)| {
        let mut bytes = format!("ply\nformat {format} 1.0\n{}end_header\n", elements.concat()).into_bytes();
        bytes.extend(data);
        bytes
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, rng_seed: RngSeed::Fixed(2), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        read_all(&bytes);
    }

    #[test]
    fn damaged_files(
        seed in any::<prop::sample::Index>(),
        end in any::<prop::sample::Index>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), 0u8..8), 0..6),
        splice in prop::option::of((any::<prop::sample::Index>(), any::<prop::sample::Index>(), any::<prop::sample::Index>())),
    ) {
        let seeds = &*SEEDS;
        let mut bytes = seeds[seed.index(seeds.len())].clone();
        for (at, bit) in flips {
            if !bytes.is_empty() {
                let at = at.index(bytes.len());
                bytes[at] ^= 1 << bit;
            }
        }
        if let Some((other, from, at)) = splice {
            let other = &seeds[other.index(seeds.len())];
            let at = at.index(bytes.len() + 1);
            bytes.splice(at..at, other[from.index(other.len() + 1)..].iter().copied());
        } else {
            bytes.truncate(end.index(bytes.len() + 1));
        }
        read_all(&bytes);
    }

    #[test]
    fn any_obj_statements(text in obj_text(), library in mtl_text()) {
        check(&read_obj(text.as_bytes(), library.as_bytes()));
    }

    #[test]
    fn any_mtl_statements(text in mtl_text()) {
        check(&read_obj(b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n", text.as_bytes()));
    }

    #[test]
    fn any_stl_words(text in prop_oneof![stl_text(), stl_facets()]) {
        check(&read_stl(text.as_bytes()));
    }

    #[test]
    fn any_off_numbers(text in off_text()) {
        check(&read_off(text.as_bytes()));
    }

    #[test]
    fn any_ply_header_and_data(bytes in ply_bytes()) {
        check(&read_ply(&bytes));
    }
}

fn stl_text() -> impl Strategy<Value = String> {
    let words = vec![
        "solid",
        "endsolid",
        "facet normal",
        "outer loop",
        "vertex",
        "vertex",
        "vertex",
        "endloop",
        "endfacet",
        "loop",
        "x",
    ];
    prop::collection::vec(line(words, number(), 5), 0..40).prop_map(|lines| format!("solid a\n{}", lines.concat()))
}

/// Well-formed facets of few coordinates, so that they meet, with anything between.
fn stl_facets() -> impl Strategy<Value = String> {
    let coordinate = || prop_oneof![12 => (0u8..3).prop_map(|i| i.to_string()), 1 => number()];
    let vertex = [coordinate(), coordinate(), coordinate()].prop_map(|v| format!("vertex {}\n", v.join(" ")));
    let facet = prop::collection::vec(vertex, 3..6)
        .prop_map(|corners| format!("facet normal 0 0 1 outer loop\n{}endloop endfacet\n", corners.concat()));
    prop::collection::vec(facet, 0..12).prop_map(|facets| format!("solid a\n{}endsolid a\n", facets.concat()))
}

fn off_text() -> impl Strategy<Value = String> {
    let header = prop::sample::select(vec![
        "OFF",
        "COFF",
        "NOFF",
        "STOFF",
        "STCNOFF",
        "CNOFF",
        "4OFF",
        "OFF BINARY",
        "OFFX",
        "",
    ]);
    let count = || prop_oneof![12 => (0u8..6).prop_map(|i| i.to_string()), 1 => number()];
    let data = prop::collection::vec(
        prop_oneof![8 => (0u8..5).prop_map(|i| i.to_string()), 1 => number(), 3 => Just("\n".to_owned())],
        0..80,
    );
    (header, [count(), count(), count()], data)
        .prop_map(|(header, counts, data)| format!("{header}\n{}\n{}", counts.join(" "), data.join(" ")))
}

#[test]
fn every_truncation_of_every_file() {
    for seed in SEEDS.iter() {
        for end in 0..=seed.len().min(600) {
            read_all(&seed[..end]);
        }
    }
}
