//! `etendue simplify`: what goes in, what comes out, and what is told.
#![allow(clippy::disallowed_methods, reason = "tests are not compared bit by bit")]

mod common;

use common::Folder;
use serde_json::Value;
use std::{f64::consts::TAU, fmt::Write, fs};

/// A torus of `around` x `across` quadrilaterals with texture coordinates (their seams are open), normals, and two materials.
fn torus(around: usize, across: usize) -> String {
    let mut text = String::from("mtllib t.mtl\no ring\n");
    let angle = |i: usize, n: usize| TAU * i as f64 / n as f64;
    for i in 0..around {
        for k in 0..across {
            let (a, b) = (angle(i, around), angle(k, across));
            let r = 1.0 + 0.4 * b.cos();
            let _ = writeln!(text, "v {} {} {}", r * a.cos(), 0.4 * b.sin(), -r * a.sin());
            let _ = writeln!(text, "vn {} {} {}", b.cos() * a.cos(), b.sin(), -b.cos() * a.sin());
        }
    }
    for i in 0..=around {
        for k in 0..=across {
            let _ = writeln!(text, "vt {} {}", i as f64 / around as f64, k as f64 / across as f64);
        }
    }
    for i in 0..around {
        let _ = writeln!(text, "{}", if 2 * i < around { "usemtl red" } else { "usemtl blue" });
        for k in 0..across {
            let corner = |i: usize, k: usize| {
                let vertex = i % around * across + k % across + 1;
                format!("{vertex}/{}/{vertex}", i * (across + 1) + k + 1)
            };
            let _ =
                writeln!(text, "f {} {} {} {}", corner(i, k), corner(i + 1, k), corner(i + 1, k + 1), corner(i, k + 1));
        }
    }
    text
}

const MTL: &str = "newmtl red\nKd 0.8 0.1 0.1\nmap_Kd red.png\nnewmtl blue\nKd 0.1 0.1 0.8\n";
/// One red pixel.
const PIXEL: &[u8] = &[
    137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 1, 0, 0, 0, 1, 8, 2, 0, 0, 0, 144, 119, 83,
    222, 0, 0, 0, 12, 73, 68, 65, 84, 120, 156, 99, 248, 207, 192, 0, 0, 3, 1, 1, 0, 201, 254, 146, 239, 0, 0, 0, 0,
    73, 69, 78, 68, 174, 66, 96, 130,
];
/// Four corners, which cannot be fewer.
const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.put("t.obj", torus(48, 24));
    folder.put("t.mtl", MTL);
    folder.put("tetrahedron.obj", TETRAHEDRON);
    folder
}

fn info(folder: &Folder, name: &str) -> Value {
    folder.run(&format!("info {name} --json")).with_code(0).json()
}

#[test]
fn a_model_with_all_that_it_has() {
    let folder = folder();
    let ended = folder.run("simplify t.obj -o small.obj --faces 500 --json --measure 2000").with_code(0);
    let ended = ended.saying(&["1 named object or group", "small.obj: 500 triangles of 2,304", "distance: rms"]);
    let json = ended.json();
    for (key, value) in [("faces_in", 2304), ("faces_out", 500), ("vertices_in", 25 * 49)] {
        assert_eq!(json[key], value, "{key} in {json}");
    }
    assert!(json["vertices_out"].as_u64().unwrap() >= 250 && json["collapses"].as_u64().unwrap() > 800, "{json}");
    assert!(json["refused"].is_u64() && json["stopped"].is_null() && json["turned"] == 0, "{json}");
    for key in ["load", "simplify", "polish", "measure", "write"] {
        assert!(json["seconds"][key].as_f64().unwrap() >= 0.0, "{key} in {json}");
    }
    if cfg!(target_os = "linux") {
        assert!(json["peak_memory"].as_u64().unwrap() > 1 << 20, "{json}");
    }
    let distance = &json["distance"];
    let number = |value: &Value| value.as_f64().unwrap();
    assert!((number(&distance["diagonal"]) - (2.8f64 * 2.8 * 2.0 + 0.64).sqrt()).abs() < 1e-3, "{json}");
    for key in ["rms", "largest"] {
        let both = ["forth", "back"].map(|way| number(&distance[way][key]));
        assert_eq!(number(&distance[key]), both[0].max(both[1]));
        let relative = number(&distance[format!("relative_{key}")]);
        assert!((relative * number(&distance["diagonal"]) / number(&distance[key]) - 1.0).abs() < 1e-12);
        assert!(relative > 1e-5 && relative < 0.02, "{json}");
    }
    let after = info(&folder, "small.obj");
    assert_eq!((&after["triangles"], &after["normals"], &after["uvs"]), (&500.into(), &true.into(), &true.into()));
    let names: Vec<&str> = after["materials"].as_array().unwrap().iter().map(|m| m["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["red", "blue"]);
    assert!(fs::read_to_string(folder.path("small.mtl")).unwrap().contains("red.png"));
    assert_eq!(after["objects"].as_array().unwrap().len(), 0);
    let text = fs::read_to_string(folder.path("small.obj")).unwrap();
    assert_eq!(text.matches("usemtl").count(), 2, "faces of one material follow each other");
}

#[test]
fn formats_and_what_they_hold() {
    let folder = folder();
    folder.run("simplify t.obj -o a.ply --faces 900").with_code(0).saying(&["hold no materials"]);
    folder.run("simplify a.ply -o b.stl --ratio 0.5").with_code(0).saying(&["no texture coordinates"]);
    folder.run("simplify b.stl -o c.obj --faces 300 --quiet").with_code(0);
    for (name, most, uvs) in [("a.ply", 900, true), ("b.stl", 450, false), ("c.obj", 300, false)] {
        let info = info(&folder, name);
        assert!(info["triangles"].as_u64().unwrap() <= most, "{info}");
        assert_eq!(info["uvs"], uvs, "{info}");
    }
    // Nothing is said of what nobody wants.
    let ended = folder.run("simplify t.obj -o d.stl --faces 100 --keep none").with_code(0);
    assert!(!ended.stderr.contains("hold no"), "{ended:#?}");
    folder.run("simplify t.obj -o e.obj --faces 200 --keep normals").with_code(0);
    let e = info(&folder, "e.obj");
    assert_eq!((&e["normals"], &e["uvs"], e["materials"].as_array().unwrap().len()), (&true.into(), &false.into(), 0));
    assert_eq!(
        folder.run("simplify t.obj -o f.obj --faces 200 --quiet").with_code(0).stderr.matches("f.obj").count(),
        0
    );
}

#[test]
fn every_option_runs() {
    let folder = folder();
    for options in [
        "--faces 300 --method quadric-union",
        "--faces 300 --method shortest-edge",
        "--ratio 0.2 --placement probabilistic",
        "--ratio 0.2 --sigma 0.1",
        "--ratio 0.2 --placement perturbed --seed 5",
        "--ratio 0.2 --placement endpoint",
        "--ratio 0.2 --placement midpoint",
        "--faces 300 --keep-boundary --crease-angle 20",
        "--faces 300 --fast",
        "--faces 300 --no-polish",
        "--faces 0",
    ] {
        let ended = folder.run(&format!("simplify t.obj -o o.obj --json --quiet {options}")).with_code(0);
        let json = ended.json();
        if options != "--faces 0" {
            assert!(json["faces_out"].as_u64().unwrap() <= 461, "{options}: {json}");
        }
    }
    let exact = folder.run("simplify t.obj -o o.ply --max-error 0.3% --json --measure 20000").with_code(0).json();
    assert!(exact["distance"]["relative_largest"].as_f64().unwrap() <= 0.003 * 1.02, "{exact}");
    let of_unit = folder.run("simplify t.obj -o o.ply --max-error 0.05 --json --measure 20000").with_code(0).json();
    assert!(of_unit["distance"]["largest"].as_f64().unwrap() <= 0.05 * 1.02, "{of_unit}");
    assert!(of_unit["faces_out"].as_u64().unwrap() < exact["faces_out"].as_u64().unwrap(), "{of_unit}");
}

#[test]
fn targets_that_cannot_be_reached() {
    let folder = folder();
    let parts = ["the target is not reached, 4 triangles are left"];
    let json = folder.run("simplify tetrahedron.obj -o a.obj --faces 1 --json").with_code(0).saying(&parts).json();
    assert!(json["stopped"].is_string() && json["faces_out"] == 4, "{json}");
    folder.run("simplify tetrahedron.obj -o b.obj --faces 1 --require-target").with_code(5).saying(&parts);
    assert_eq!(info(&folder, "b.obj")["triangles"], 4);
    folder.run("simplify tetrahedron.obj -o b.obj --faces 4 --require-target").with_code(0);
}

#[test]
fn locked_vertices_are_those_of_the_file() {
    let folder = folder();
    // The OBJ file's vertices 0, 30 and 1151; the first five of an added one are used by no face.
    let obj = fs::read_to_string(folder.path("t.obj")).unwrap();
    let place = |text: &str, number: usize| {
        let line = text.lines().filter(|line| line.starts_with("v ")).nth(number).unwrap();
        line[2..].split(' ').map(|n| n.parse::<f64>().unwrap() as f32).collect::<Vec<f32>>()
    };
    folder.put("lock.txt", "0 # the first\n\n30\r\n1151");
    folder.run("simplify t.obj -o out.obj --faces 200 --lock lock.txt").with_code(0);
    let out = fs::read_to_string(folder.path("out.obj")).unwrap();
    let all: Vec<Vec<f32>> = (0..out.matches("\nv ").count()).map(|i| place(&out, i)).collect();
    for number in [0, 30, 1151] {
        assert!(all.contains(&place(&obj, number)), "vertex {number} moved");
    }
    // In PLY and STL files too, whatever their readers leave out.
    let ply = "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\nproperty float z\n\
               element face 6\nproperty list uchar int vertex_indices\nend_header\n\
               9 9 9\n0 0 0\n1 0 0.1\n1 1 0\n0 1 0.1\n0.5 0.5 0.9\n0.4 0.4 -0.5\n\
               3 1 2 5\n3 2 3 5\n3 3 4 5\n3 4 1 5\n3 2 1 6\n3 1 4 6\n";
    folder.put("a.ply", ply);
    folder.put("lock.txt", "1\n2\n3\n4\n5\n6\n0\n");
    let json = folder.run("simplify a.ply -o b.obj --faces 2 --lock lock.txt --json").with_code(0).json();
    assert_eq!(json["faces_out"], 6, "{json}");
    folder.run("convert a.ply a.stl").with_code(0);
    folder.put("lock.txt", "0\n1\n2\n3\n4\n5\n");
    assert_eq!(folder.run("simplify a.stl -o b.obj --faces 2 --lock lock.txt --json").json()["faces_out"], 6);
    folder.put("lock.txt", "1\n 7\nx\n");
    let parts = ["lock.txt:2:2", "there is no vertex 7: the model has 7", "from 0 to 6", "lock.txt:3:1", "2 errors"];
    folder.run("simplify a.ply -o c.obj --faces 2 --lock lock.txt").with_code(2).saying(&parts);
    folder.run("simplify a.ply -o c.obj --faces 2 --lock none.txt").with_code(2).saying(&["none.txt"]);
    assert!(!folder.path("c.obj").exists());
}

#[test]
fn what_is_wrong_is_told_and_nothing_written() {
    let folder = folder();
    folder.put("words.obj", "words");
    folder.put("old.obj", "as it was");
    for (words, code, part) in [
        ("simplify t.obj --faces 9", 1, "--output"),
        ("simplify t.obj -o old.obj", 1, "--faces"),
        ("simplify t.obj -o old.obj --faces 9 --ratio 0.5", 1, "cannot be used with"),
        ("simplify t.obj -o old.obj --ratio 1.5", 1, "at most 1"),
        ("simplify t.obj -o old.obj --max-error 0", 1, "0.1% of the diagonal"),
        ("simplify t.obj -o old.obj --faces 9 --keep uvs", 1, "uv, normals"),
        ("simplify t.obj -o old.obj --faces 9 --placement endpoint --sigma 0.1", 1, "probabilistic"),
        ("simplify t.obj -o old.obj --faces 9 --crease-angle 200", 1, "at most 180"),
        ("simplify t.obj -o old.obj --faces 9 --method cluster", 1, "quadric-union"),
        ("simplify t.obj -o old.obj --faces 9 --measure 0", 1, "1..="),
        ("simplify t.obj -o old.off --faces 9", 1, ".stl"),
        ("simplify scene.toml -o old.obj --faces 9", 2, "cannot read scene.toml as a mesh"),
        ("simplify none.obj -o old.obj --faces 9", 2, "none.obj"),
        ("simplify words.obj -o old.obj --faces 9", 2, "words.obj"),
        ("simplify a.glb -o old.obj --faces 9", 3, "not read yet"),
        ("simplify t.obj -o no/a.obj --faces 9", 4, "no/a.obj"),
    ] {
        folder.run(words).with_code(code).saying(&[part]);
    }
    assert_eq!(fs::read_to_string(folder.path("old.obj")).unwrap(), "as it was");
    assert_eq!(folder.files(), ["old.obj", "t.mtl", "t.obj", "tetrahedron.obj", "words.obj"]);
}

#[test]
fn odd_models() {
    let folder = Folder::new();
    let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let vertices = "0 0 0\n1 0 0\n0 1 0\n";
    folder.put(
        "empty.ply",
        format!("{head}element face 0\nproperty list uchar int vertex_indices\nend_header\n{vertices}"),
    );
    let json = folder.run("simplify empty.ply -o a.ply --ratio 0.5 --json --measure 10").with_code(0).json();
    assert_eq!((&json["faces_out"], &json["distance"]), (&0.into(), &Value::Null), "{json}");
    folder.put("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let json = folder.run("simplify one.obj -o b.obj --faces 1 --json --measure 10").with_code(0).json();
    assert_eq!((&json["faces_in"], &json["faces_out"]), (&1.into(), &1.into()), "{json}");
    // The same face twice, and one with two corners at one place.
    folder.put("twice.obj", format!("{TETRAHEDRON}v 0 0 0\nf 1 3 2\nf 1 2 5\n"));
    let ended = folder.run("simplify twice.obj -o c.obj --ratio 1 --json").with_code(0);
    let ended = ended.saying(&["1 face twice there left out", "1 face with two corners at one place left out"]);
    let json = ended.json();
    assert_eq!(
        (&json["faces_out"], &json["dropped"]["duplicate"], &json["dropped"]["degenerate"]),
        (&4.into(), &1.into(), &1.into())
    );
    folder.put("s.obj", "sphere 0 0 0 1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.run("simplify s.obj -o d.obj --faces 1").with_code(0);
    assert_eq!(info(&folder, "d.obj")["spheres"], 1);
}

#[test]
fn numbers_that_are_none_and_edges_of_many_faces() {
    let folder = Folder::new();
    let header = |vertices: u32, faces: u32| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let tetrahedron = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
    let sides = "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
    folder.put("nan.ply", format!("{}{tetrahedron}nan 0 0\n1e39 0 0\n{sides}3 0 1 4\n3 0 1 5\n", header(6, 6)));
    let ended = folder.run("simplify nan.ply -o a.ply --ratio 1 --json --measure 100");
    // Readers may refuse such numbers, and say where they are; what they let pass is left out.
    if ended.code == 2 {
        ended.with_code(2).saying(&["nan.ply"]);
        assert!(!folder.path("a.ply").exists());
    } else {
        let json = ended.with_code(0).saying(&["2 faces with a corner not finite left out"]).json();
        assert_eq!((&json["faces_out"], &json["dropped"]["non_finite"]), (&4.into(), &2.into()), "{json}");
    }
    // Three tetrahedra at one edge, and two that touch at a corner.
    let others = "0 -1 0.2\n0.3 -0.3 -1\n0.5 -1 -0.9\n";
    let more = "3 0 1 4\n3 1 0 5\n3 1 5 4\n3 5 0 4\n3 3 4 6\n3 4 3 5\n";
    folder.put("edge.ply", format!("{}{tetrahedron}{others}{sides}{more}", header(7, 10)));
    let json = folder.run("simplify edge.ply -o b.ply --faces 1 --json --measure 100").with_code(0).json();
    assert!(json["faces_out"].as_u64().unwrap() <= 10 && json["stopped"].is_string(), "{json}");
    assert!(json["distance"]["relative_largest"].as_f64().unwrap() < 1.0, "{json}");
    let ended = folder.run("simplify edge.ply -o b.ply --faces 1 --require-target").with_code(5);
    ended.saying(&["the target is not reached", "edges left"]);
    // A model of nothing but faces that are none.
    folder.put("none.ply", format!("{}{tetrahedron}3 0 0 1\n3 2 2 2\n", header(4, 2)));
    let json = folder.run("simplify none.ply -o c.ply --ratio 0.5 --json --max-error 1%");
    assert_eq!(json.code, 1, "two targets are none: {json:?}");
    for goal in ["--faces 1", "--max-error 1%", "--ratio 0.5"] {
        let ended = folder.run(&format!("simplify none.ply -o c.ply {goal} --json --measure 10")).with_code(0);
        let json = ended.saying(&["2 faces with fewer than three different corners skipped"]).json();
        assert_eq!((&json["faces_out"], &json["distance"]), (&0.into(), &Value::Null), "{goal}: {json}");
    }
}

#[test]
fn textures_are_found_from_where_the_output_is() {
    let folder = folder();
    fs::create_dir(folder.path("far")).unwrap();
    folder.put("red.png", PIXEL);
    folder.run("simplify t.obj -o far/small.obj --faces 500").with_code(0);
    let mtl = fs::read_to_string(folder.path("far/small.mtl")).unwrap();
    let line = mtl.lines().find(|line| line.contains("map_Kd")).unwrap();
    let name = line.rsplit(' ').next().unwrap();
    assert!(folder.path("far").join(name).is_file(), "{line}");
    folder.put("far/scene.toml", format!("{}\n[[objects]]\nfile = \"small.obj\"\n", common::SCENE));
    let ended = folder.run("render far/scene.toml -o far/x.png").with_code(0);
    assert!(!ended.stderr.contains("warning"), "{ended:#?}");
}

#[test]
fn help_has_examples_and_words_have_no_colour_where_none_is_wanted() {
    let folder = folder();
    let help = folder.run("simplify --help").with_code(0).stdout;
    for part in [
        "Examples:",
        "--faces <N>",
        "--ratio <R>",
        "--max-error <E>",
        "--method <M>",
        "quadric-union",
        "shortest-edge",
        "--placement <P>",
        "perturbed",
        "--keep-boundary",
        "--crease-angle <DEG>",
        "--keep <LIST>",
        "--lock <FILE>",
        "--fast",
        "--no-polish",
        "--require-target",
        "--measure <N>",
        "--seed <N>",
        "--json",
        "--quiet",
    ] {
        assert!(help.contains(part), "{part} in {help}");
    }
    for words in ["simplify none.obj -o a.obj --faces 9", "simplify tetrahedron.obj -o a.obj --faces 1"] {
        let output = folder.command(words).env("NO_COLOR", "1").env("CLICOLOR_FORCE", "1").output().unwrap();
        let ended = common::Ended::from(output, words);
        assert!(!ended.stderr.is_empty() && !ended.stderr.contains('\x1b'), "{ended:#?}");
    }
    let quiet = folder.run("simplify t.obj -o a.obj --faces 300 --quiet").with_code(0);
    assert!(quiet.stderr.is_empty() && quiet.stdout.is_empty(), "{quiet:#?}");
}

#[test]
fn the_same_file_for_any_number_of_threads() {
    let folder = folder();
    for options in ["", "--fast", "--placement perturbed --seed 3", "--method quadric-union"] {
        let files = ["1", "2", "5"].map(|threads| {
            let words = format!("simplify t.obj -o out.obj --faces 400 {options}");
            let output = folder.command(&words).env("RAYON_NUM_THREADS", threads).output().unwrap();
            common::Ended::from(output, &words).with_code(0);
            fs::read(folder.path("out.obj")).unwrap()
        });
        assert!(files[0] == files[1] && files[1] == files[2], "{options}");
    }
}

#[test]
fn scenes_simplify_their_meshes() {
    let folder = folder();
    let scene = |simplify: &str| {
        format!(
            "{}\n[[objects]]\nfile = \"t.obj\"\n{simplify}\n[[objects]]\nfile = \"t.obj\"\n{simplify}\n",
            common::SCENE
        )
    };
    folder.put("red.png", []);
    folder.run("convert scene.toml x.png").with_code(1);
    folder.put("t.mtl", "newmtl red\nKd 0.8 0.1 0.1\nnewmtl blue\nKd 0.1 0.1 0.8\n");
    folder.put("a.toml", scene("simplify = { faces = 300 }"));
    let told = folder.run("info a.toml --json").with_code(0).json();
    assert_eq!(told["triangles"], 300, "both objects share one mesh: {told}");
    assert_eq!((&told["imports"][0]["triangles"], &told["imports"][0]["simplified_from"]), (&300.into(), &2304.into()));
    let text = folder.run("info a.toml").with_code(0).stdout;
    assert!(text.contains("t.obj: 300 triangles of 2,304"), "{text}");
    let hash =
        |scene: &str| folder.run(&format!("render {scene} --json -o x.png")).with_code(0).json()["film_hash"].clone();
    let (whole, simple) = (scene(""), scene("simplify = { ratio = 0.2, fast = true, polish = false }"));
    folder.put("whole.toml", whole);
    folder.put("simple.toml", simple);
    assert_ne!(hash("whole.toml"), hash("a.toml"));
    assert_ne!(hash("simple.toml"), hash("a.toml"));
    assert_eq!(hash("a.toml"), hash("a.toml"));
    folder.put(
        "tetra.toml",
        format!("{}\n[[objects]]\nfile = \"tetrahedron.obj\"\nsimplify = {{ faces = 1 }}\n", common::SCENE),
    );
    folder.run("info tetra.toml").with_code(0);
    folder
        .run("render tetra.toml -o x.png")
        .with_code(0)
        .saying(&["tetra.toml:", "simplified from 4 to no less than 4"]);
}

/// What was there stays as it was when somebody is tired of waiting.
#[cfg(target_os = "linux")]
#[test]
fn an_interruption_leaves_nothing_behind() {
    use std::{
        process::{Command, Stdio},
        thread,
        time::{Duration, Instant},
    };
    let folder = folder();
    folder.put("out.obj", "as it was");
    // So many samples that it would not end.
    let mut command = folder.command("simplify t.obj -o out.obj --faces 200 --measure 1073741824");
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // Signals that come before the program listens would just kill it.
    let listens = || {
        let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
        u64::from_str_radix(mask.trim(), 16).unwrap() & 2 != 0
    };
    let start = Instant::now();
    while !listens() {
        assert!(start.elapsed() < Duration::from_secs(60));
        thread::sleep(Duration::from_millis(10));
    }
    thread::sleep(Duration::from_millis(500));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let ended = common::Ended::from(child.wait_with_output().unwrap(), "interrupted").with_code(130);
    assert_eq!(ended.stdout, "");
    assert_eq!(fs::read_to_string(folder.path("out.obj")).unwrap(), "as it was");
    assert_eq!(folder.files(), ["out.obj", "t.mtl", "t.obj", "tetrahedron.obj"], "no parts are left behind");
}
