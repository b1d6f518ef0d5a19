//! Models without a scene file: the same picture as their automatic scene, framed, lit, whatever their size and place.

mod common;

use common::Folder;
use etendue::image::Image;
use std::fmt::Write;

/// A box of corners `min` and `max` as OBJ, with texture coordinates.
fn cuboid(min: [f64; 3], max: [f64; 3]) -> String {
    let mut text = String::new();
    for i in 0..8 {
        let at = |axis: usize| if i >> axis & 1 == 1 { max[axis] } else { min[axis] };
        writeln!(text, "v {} {} {}\nvt {} {}", at(0), at(1), at(2), i & 1, i >> 1 & 1).unwrap();
    }
    for face in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
        let corners = face.map(|i| format!("{i}/{i}"));
        writeln!(text, "f {}", corners.join(" ")).unwrap();
    }
    text
}

fn cube() -> String {
    cuboid([-1.0; 3], [1.0; 3])
}

/// A room of six sides but for those left out, with a lamp below its ceiling.
fn room(left_out: &[usize]) -> Folder {
    let folder = Folder::new();
    let mut text = "mtllib room.mtl\nusemtl wall\n".to_owned();
    let mut side = 0;
    for line in cuboid([0.0; 3], [4.0, 3.0, 5.0]).lines() {
        let is_face = line.starts_with('f');
        if !(is_face && left_out.contains(&side)) {
            text += &format!("{line}\n");
        }
        side += usize::from(is_face);
    }
    text += "usemtl lamp\nv 1.5 2.9 2\nv 2.5 2.9 2\nv 2.5 2.9 3\nv 1.5 2.9 3\nf -4 -3 -2 -1\n";
    folder.put("room.obj", text);
    folder.put("room.mtl", "newmtl wall\nKd 0.7 0.7 0.7\nnewmtl lamp\nKd 0 0 0\nKe 12 11 10\n");
    folder
}

fn film_hash(folder: &Folder, words: &str) -> String {
    let ended = folder.run(&format!("render {words} --json --quiet")).with_code(0);
    ended.json()["film_hash"].as_str().unwrap().to_owned()
}

#[test]
fn a_model_renders_as_its_automatic_scene_does() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("scenes")).unwrap();
    folder.put("m.obj", cube());
    let sky = "sky.pfm";
    let mut pixels = b"PF\n4 2\n-1.0\n".to_vec();
    (0..24).for_each(|i| pixels.extend((0.1 * i as f32).to_le_bytes()));
    folder.put(sky, pixels);
    let mut seen = Vec::new();
    for options in [
        "",
        "--view front",
        "--view side --up z",
        "--view top --no-ground",
        "--view iso --material glass",
        "--transparent --material gold",
        "--env sky.pfm",
        "--env sky.pfm --material sky.pfm --no-ground",
    ] {
        let size = "--size 24x16";
        folder.run(&format!("scene m.obj {size} {options} -o scenes/s.toml")).with_code(0);
        let of_scene = film_hash(&folder, "scenes/s.toml --spp 2 -o a.exr");
        let of_model = film_hash(&folder, &format!("m.obj {size} {options} --spp 2 -o b.exr"));
        assert_eq!(of_scene, of_model, "{options}");
        assert!(!seen.contains(&of_model), "{options} changes the picture");
        seen.push(of_model);
    }
    let on_output = folder.run("scene m.obj --size 24x16").with_code(0).stdout;
    folder.put("c.toml", on_output);
    assert_eq!(film_hash(&folder, "c.toml --spp 2 -o c.exr"), seen[0]);
}

#[test]
fn models_and_scenes_may_lie_in_folders_with_strange_names() {
    let folder = Folder::new();
    for name in ["a b", "é\"quoted\"", "deep"] {
        std::fs::create_dir(folder.path(name)).unwrap();
    }
    folder.put("é\"quoted\"/m 1.obj", cube());
    let run = |words: &[&str]| folder.command("").args(words).output().unwrap();
    let model = "é\"quoted\"/m 1.obj";
    let written = run(&["scene", model, "-o", "a b/s.toml"]);
    assert!(written.status.success(), "{written:?}");
    let small = ["--size", "8x8", "--spp", "1", "-o"];
    let rendered = run(&[&["render", "a b/s.toml"][..], &small, &["a.png"]].concat());
    assert!(rendered.status.success(), "{rendered:?}");
    let rendered = run(&[&["render", model][..], &small, &["b.png"]].concat());
    assert!(rendered.status.success(), "{rendered:?}");
}

/// The rows and columns between which the picture is not transparent, and its size.
fn silhouette(image: &Image) -> [f64; 4] {
    let alpha = image.f32_channel("A").unwrap();
    let (width, height) = (image.width as usize, image.height as usize);
    let seen = |x: usize, y: usize| alpha[y * width + x] > 0.2;
    let columns: Vec<usize> = (0..width).filter(|&x| (0..height).any(|y| seen(x, y))).collect();
    let rows: Vec<usize> = (0..height).filter(|&y| (0..width).any(|x| seen(x, y))).collect();
    let share = |range: &[usize], size: usize| {
        let (first, last) = (range[0], range[range.len() - 1] + 1);
        [(last - first) as f64 / size as f64, (first + last) as f64 / size as f64]
    };
    let ([w, x], [h, y]) = (share(&columns, width), share(&rows, height));
    [w, h, x, y]
}

#[test]
fn whatever_its_size_shape_and_place_a_model_fills_the_frame() {
    let folder = Folder::new();
    let shifted = |by: [f64; 3], size: f64| cuboid(by, by.map(|c| c + size));
    let models = [
        ("cube", cube()),
        ("huge", shifted([3e7, 2e6, -5e7], 1e6)),
        ("tiny", shifted([0.0; 3], 1e-6)),
        ("far", shifted([1e9, -2e9, 1e9], 10.0)),
        ("galaxy", shifted([-1e16; 3], 2e16)),
        ("atom", shifted([0.0; 3], 1e-12)),
        ("pole", cuboid([0.0; 3], [0.3, 9.0, 0.3])),
        ("sheet", cuboid([0.0; 3], [9.0, 0.01, 4.0])),
        ("plane", "v 0 0 0\nv 3 0 0\nv 3 2 0\nv 0 2 0\nf 1 2 3 4\n".to_owned()),
        ("floor", "v 0 0 0\nv 3 0 0\nv 3 0 -2\nv 0 0 -2\nf 1 2 3 4\n".to_owned()),
        ("back", "v 0 0 0\nv 3 0 0\nv 3 2 0\nv 0 2 0\nf 4 3 2 1\n".to_owned()),
        ("triangle", "v 0 0 0\nv 1 0 0\nv 0.3 1 0.2\nf 1 2 3\n".to_owned()),
        ("stray", format!("{}v 1000 1000 1000\n", cube())),
        ("sphere", "sphere 5 6 7 0.5\n".to_owned()),
    ];
    for (name, model) in models {
        folder.put("m.obj", model);
        for view in ["", "--view front", "--view side", "--view top", "--view iso", "--up z"] {
            // From their edges there is little to see of flat ones.
            if !view.is_empty() && ["plane", "floor", "back", "triangle", "sheet", "pole"].contains(&name) {
                continue;
            }
            let words =
                format!("render m.obj --transparent --size 120x80 --spp 4 --filter box {view} -o a.exr --quiet");
            folder.run(&words).with_code(0);
            let [w, h, x, y] = silhouette(&folder.image("a.exr"));
            let what = format!("{name} {view}: {w} x {h}, middle {x}, {y}");
            assert!((0.8..0.92).contains(&w.max(h)), "fills the frame: {what}");
            assert!((x - 1.0).abs() < 0.04 && (y - 1.0).abs() < 0.05, "in the middle: {what}");
        }
    }
}

#[test]
fn flat_models_are_seen_from_their_front() {
    let folder = Folder::new();
    for (model, axis, sign) in [
        ("v 0 0 0\nv 3 0 0\nv 3 2 0\nv 0 2 0\nf 1 2 3 4\n", 2, 1.0),
        ("v 0 0 0\nv 3 0 0\nv 3 2 0\nv 0 2 0\nf 4 3 2 1\n", 2, -1.0),
        ("v 0 0 0\nv 0 3 0\nv 0 3 2\nv 0 0 2\nf 1 2 3 4\n", 0, 1.0),
        ("v 0 0 0\nv 3 0 0\nv 3 0 -2\nv 0 0 -2\nf 1 2 3 4\n", 1, 1.0),
        ("v 0 0 0\nv 3 0 0\nv 3 0 -2\nv 0 0 -2\nf 4 3 2 1\n", 1, 1.0),
    ] {
        folder.put("m.obj", model);
        let scene: toml::Table = folder.run("scene m.obj").with_code(0).stdout.parse().unwrap();
        let number = |value: &toml::Value| value.as_float().unwrap_or_else(|| value.as_integer().unwrap() as f64);
        let point = |key: &str| scene["camera"][key].as_array().unwrap().iter().map(number).collect::<Vec<f64>>();
        let back: Vec<f64> = point("position").iter().zip(point("look_at")).map(|(p, t)| p - t).collect();
        let length = back.iter().map(|c| c * c).sum::<f64>().sqrt();
        assert!(back[axis] * sign / length > 0.7, "{model}: {back:?}");
    }
}

/// Mean of the colour in rows `rows`, of the outer thirds.
fn mean(image: &Image, rows: std::ops::Range<usize>) -> f64 {
    let (width, mut sum, mut count) = (image.width as usize, 0.0, 0.0);
    for row in rows {
        for x in (0..width / 3).chain(2 * width / 3..width) {
            for channel in ["R", "G", "B"] {
                sum += f64::from(image.f32_channel(channel).unwrap()[row * width + x]);
                count += 1.0;
            }
        }
    }
    sum / count
}

#[test]
fn the_ground_runs_into_the_horizon() {
    let folder = Folder::new();
    folder.put("m.obj", cube());
    folder.run("render m.obj --view front --size 96x64 --spp 64 -o a.exr --quiet").with_code(0);
    let image = folder.image("a.exr");
    let (sky, ground) = (mean(&image, 30..32), mean(&image, 32..34));
    assert!((ground / sky - 1.0).abs() < 0.06, "no edge: {ground} below {sky}");
    let (above, near) = (mean(&image, 0..4), mean(&image, 58..64));
    assert!(near > 1.5 * sky && near < 1.0, "the lamp lights the ground near the model: {near}");
    assert!(above > 0.02 && above < 0.6, "the sky is there, and dark: {above}");
}

#[test]
fn a_room_with_a_lamp_is_lit_by_that_and_looked_into() {
    // Sides of `cuboid` by their place: low z, high z, low y, high y, low x, high x.
    for (side, axis, sign) in [(0, 2, -1.0), (1, 2, 1.0), (4, 0, -1.0), (5, 0, 1.0)] {
        let folder = room(&[side]);
        let text = folder.run("scene room.obj").with_code(0).stdout;
        let scene: toml::Table = text.parse().unwrap();
        assert!(text.contains("into the open side") && !scene.contains_key("environment"), "{text}");
        assert_eq!(scene["objects"].as_array().unwrap().len(), 1, "no ground, no lamp");
        let position = scene["camera"]["position"].as_array().unwrap()[axis].as_float().unwrap();
        assert!(position * sign > 0.0, "side {side}: {text}");
        folder.run("render room.obj --size 48x36 --spp 16 -o a.exr -o a.png --quiet").with_code(0);
        let image = folder.image("a.png");
        let middle = mean(&image, 6..30);
        assert!((0.05..0.8).contains(&middle), "side {side}: {middle}");
    }
    let folder = room(&[]);
    assert!(folder.run("scene room.obj").with_code(0).stdout.contains("inside the closed room"));
    folder.run("render room.obj --size 24x18 --spp 4 -o a.exr --quiet").with_code(0);
    assert!(mean(&folder.image("a.exr"), 0..18) > 1e-3);
    // A material for all is no lamp.
    assert!(folder.run("scene room.obj --material clay").with_code(0).stdout.contains("[environment]"));
}

#[test]
fn what_cannot_be_shown_is_told() {
    let folder = Folder::new();
    folder.put("empty.obj", "v 0 0 0\nv 1 0 0\n");
    folder.put("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    folder.put("point.obj", "v 0 0 0\nf 1 1 1\n");
    folder.put("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.put("broken.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
    folder.put("a.png", "");
    folder.put("a.glb", "glTF");
    for (words, code, part) in [
        ("render empty.obj", 2, "no faces"),
        ("scene empty.obj", 2, "no faces"),
        ("render line.obj", 2, "no area"),
        ("render point.obj", 2, "the model has no faces"),
        ("render broken.ply", 2, "broken.ply"),
        ("render none.obj", 2, "none.obj"),
        ("render a.glb", 3, "not read yet"),
        ("scene a.glb", 3, "not read yet"),
        ("render plain.obj --material a.png", 2, "no texture coordinates"),
        ("render plain.obj --material golden", 1, "frosted-glass"),
        ("render plain.obj --view left", 1, "iso"),
        ("render plain.obj --up x", 1, "possible values: y, z"),
        ("render plain.obj --env none.hdr", 2, "none.hdr"),
        ("render plain.obj --env a.png", 2, "a.png"),
        ("render plain.obj --size 1000000x1000000", 1, "too large"),
        ("scene plain.obj --size 100000x10", 1, "65536"),
        ("render scene.toml --no-ground", 1, "--no-ground is for models"),
        ("scene scene.toml", 2, "as a mesh"),
        ("scene plain.obj -o no/such/a.toml", 4, "no/such"),
        ("scene plain.obj -o a.txt", 1, ".toml"),
    ] {
        folder.run(words).with_code(code).saying(&[part]);
    }
}

#[test]
fn a_render_tells_in_one_line_what_it_read() {
    let folder = Folder::new();
    let mtl = "newmtl a\nKd 0.5 0.5 0.5\nKa 0.1 0.1 0.1\nfancy 1\n";
    folder.put("m.obj", format!("mtllib m.mtl\nusemtl a\n{}", cube()));
    folder.put("m.mtl", mtl);
    let small = "--size 8x8 --spp 1 -o a.png";
    let ended = folder.run(&format!("render m.obj {small}")).with_code(0);
    assert!(ended.stderr.contains("m.obj: 12 triangles, 1 material; "), "{ended:#?}");
    assert!(ended.stderr.contains("ignored (etendue info m.obj tells which)"), "{ended:#?}");
    assert!(!ended.stderr.contains("note:"), "{ended:#?}");
    assert!(ended.stderr.contains("--up z"), "{ended:#?}");
    let quiet = folder.run(&format!("render m.obj {small} --quiet")).with_code(0);
    assert!(!quiet.stderr.contains("triangles"), "{quiet:#?}");
    folder.put("m.ply.gz", "");
    folder.run("render m.ply.gz").with_code(2);
}
