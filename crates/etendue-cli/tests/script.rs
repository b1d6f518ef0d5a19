//! Scripts of the older renderer through the program.

mod common;

use common::Folder;

const SCRIPT: &str = "object scene/room.obj\nscale 1.5\nambient 0.2 0.2 0.1\ncamera 6 0 0 -1 0 0 0 0 1 2.5 2 2 0.125\n\
                      pixelSampler Stratified 2\nrayTraceSampler Stratified 4 8\nthreading 3\nimageSize 16 16\nfilter 2 1 1\n";

fn folder() -> Folder {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("scene")).unwrap();
    folder.put(
        "scene/room.obj",
        "mtllib scene/1.mtl\nv -1 -1 -1\nv -1 1 -1\nv -1 1 1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nusemtl wall\nf 1 2 3 4\n\
         usemtl AreaLightSource\nf 4 3 6 5\nusemtl glass\nsphere 0 0 0 0.4\n",
    );
    folder.put(
        "scene/1.mtl",
        "newmtl wall\nKd 0.5 0.7 0.5\nKs 0.2 0.2 0.2\nNs 20\nbump t.png\nnewmtl AreaLightSource\nKd 1 1 0.85\n\
         newmtl glass\nTr 1\nTs 0.9 0.9 0.9\nn 1.5\n",
    );
    folder.put("scene/1.cfg", SCRIPT);
    folder
}

fn film_hash(folder: &Folder, words: &str) -> String {
    let ended = folder.run(&format!("render {words} --json --quiet")).with_code(0);
    ended.json()["film_hash"].as_str().unwrap().to_owned()
}

#[test]
fn a_script_renders_as_the_scene_that_is_written() {
    let folder = folder();
    folder.run("scene scene/1.cfg -o written.toml").with_code(0).saying(&["written.toml: render it"]);
    folder.run("convert scene/1.cfg scene/converted.toml").with_code(0);
    folder.put("printed.toml", folder.run("scene scene/1.cfg").with_code(0).stdout);
    folder.put("scene/1.cfg.old", SCRIPT);
    let hash = film_hash(&folder, "scene/1.cfg -o a.exr");
    for other in ["written.toml", "scene/converted.toml", "printed.toml", "scene/1.cfg.old", "scene/1.cfg --threads 1"]
    {
        assert_eq!(film_hash(&folder, &format!("{other} -o b.exr")), hash, "{other}");
    }
    assert_ne!(film_hash(&folder, "scene/1.cfg --spp 5 -o b.exr"), hash);
}

#[test]
fn what_means_something_else_is_told_unless_quiet() {
    let folder = folder();
    let notes = [
        "scene/1.cfg:3:1: note: `ambient` is the radiance of a constant environment",
        "scene/1.cfg:7:1: note: `threading` is not used; see --threads",
        "scene/1.mtl:1:1: note: `bump` on a surface with `Ks` is brushed metal",
    ];
    folder.run("render scene/1.cfg -o a.png").with_code(0).saying(&notes);
    let quiet = folder.run("render scene/1.cfg -o a.png --quiet").with_code(0);
    assert!(!quiet.stderr.contains("note"), "{quiet:?}");
    let info = folder.run("info scene/1.cfg").with_code(0);
    assert!(info.stdout.contains("scene/1.cfg: scene") && info.stdout.contains("`threading` is not used"), "{info:?}");
    let info = folder.run("info scene/1.cfg --json").with_code(0).json();
    assert_eq!((info["kind"].as_str(), info["spp"].as_u64()), (Some("scene"), Some(4)));
}

/// Bytes are proportional to the light, and the file says so.
#[test]
fn pictures_are_linear() {
    let folder = folder();
    folder.run("render scene/1.cfg -o a.png -o a.exr --quiet").with_code(0);
    let (bytes, light) = (folder.image("a.png"), folder.image("a.exr"));
    for (name, factor) in [("R", 2.0), ("G", 1.0), ("B", 1.0)] {
        for (b, l) in bytes.f32_channel(name).unwrap().iter().zip(light.f32_channel(name).unwrap()) {
            assert!((b - (l * factor).min(1.0)).abs() < 0.51 / 255.0, "{name}: {b} {l}");
        }
    }
    folder.run("render scene/1.cfg -o b.png --encoding srgb --balance 1 --quiet").with_code(0);
    let screen = folder.image("b.png");
    let near = |(b, l): (&f32, &f32)| (b - l.min(1.0)).abs() < 0.005;
    assert!(screen.f32_channel("G").unwrap().iter().zip(light.f32_channel("G").unwrap()).all(near));
}

#[test]
fn mistakes_have_their_codes() {
    let folder = folder();
    folder.run("render scene/1.cfg --view front").with_code(1).saying(&["--view is for models"]);
    folder
        .run("scene scene/1.cfg --size 4x4")
        .with_code(1)
        .saying(&["--size is for models, but scene/1.cfg is a script"]);
    folder.run("convert scene/1.cfg a.png").with_code(1).saying(&["a scene file ends in .toml"]);
    folder.run("convert scene/1.cfg a.toml --exposure 1").with_code(1).saying(&["--exposure is for pictures"]);
    folder.put("raw.cfg", "fromRaw a.raw\n");
    folder.run("render raw.cfg").with_code(3).saying(&["`fromRaw` shows a stored picture", "raw.cfg:1:1"]);
    folder.put("bad.cfg", "object scene/room.obj\nscale x\ncamera 6 0 0 -1 0 0 0 0 1 2.5 2 2 0.125\n");
    folder.run("render bad.cfg").with_code(2).saying(&["bad.cfg:2:7", "`x` is not a number"]);
    folder.put("lost.cfg", "object scene/lost.obj\ncamera 6 0 0 -1 0 0 0 0 1 2.5 2 2 0.125\n");
    folder.run("info lost.cfg").with_code(2).saying(&["no such file: scene/lost.obj", "lost.cfg:1:8"]);
    folder.run("render nowhere.cfg").with_code(2).saying(&["no such file: nowhere.cfg"]);
}
