//! `etendue simulate`.

mod common;

use common::{Folder, SCENE};
use etendue_scene::{Limits, SourceMap, keyframes};

fn folder(extra: &str) -> Folder {
    let folder = Folder::new();
    let ball = "[[objects]]\nname = \"ball\"\nshape = \"sphere\"\nradius = 0.1\ntransform = { translate = [0, 3, 0] }\nbody = { restitution = 0.5, angular_velocity = [70, 80, 90] }\n\
                [[objects]]\nname = \"floor\"\nshape = \"box\"\nmin = [-3, -4, -3]\nmax = [3, -3, 3]\nbody = \"fixed\"\n";
    folder.put("scene.toml", format!("{SCENE}\n{ball}{extra}"));
    folder
}

#[test]
fn motion_is_written_and_reads_back() {
    let folder = folder("[physics]\nduration = 0.5\n");
    let told = folder.run("simulate scene.toml -o m.json --json").with_code(0);
    let summary: serde_json::Value = serde_json::from_str(&told.stdout).unwrap();
    assert_eq!((summary["bodies"].as_u64(), summary["steps"].as_u64()), (Some(1), Some(240)));
    assert!(told.stderr.contains("m.json: 1 body, 240 steps"), "{}", told.stderr);
    let first = std::fs::read(folder.path("m.json")).unwrap();
    folder.run("simulate scene.toml -o m.json --quiet").with_code(0);
    assert_eq!(std::fs::read(folder.path("m.json")).unwrap(), first);
    let mut sources = SourceMap::new();
    let recording = keyframes::read(&folder.path("m.json"), &mut sources, &Limits::default()).unwrap();
    let text = String::from_utf8(first).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["hash"], summary["hash"]);
    assert_eq!(recording.times.unwrap().len(), 241);
    let bits = |value: &serde_json::Value| -> Vec<u64> {
        value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap().to_bits()).collect()
    };
    let (object, ball) = (&json["objects"][0], &recording.objects[0]);
    assert_eq!(bits(&object["pivot"])[..], ball.pivot.unwrap().to_array().map(f64::to_bits));
    for (step, pose) in ball.poses.iter().enumerate() {
        assert_eq!(bits(&object["positions"][step])[..], pose.translation.to_array().map(f64::to_bits), "{step}");
        assert_eq!(bits(&object["rotations"][step])[..], pose.rotation.to_array().map(f64::to_bits), "{step}");
    }
    let steps = folder.run("simulate scene.toml -o m.json --duration 1 --step 0.01 --json").with_code(0).stdout;
    let summary: serde_json::Value = serde_json::from_str(&steps).unwrap();
    assert_eq!((summary["steps"].as_u64(), summary["end"].as_f64()), (Some(100), Some(1.0)));
}

#[test]
fn what_does_not_work_is_said() {
    let still = Folder::new();
    let told = still.run("simulate scene.toml -o m.json").with_code(2).stderr;
    assert!(told.contains("no object has a dynamic body") && told.contains("body = \"dynamic\""), "{told}");
    still.run("simulate scene.toml -o m.npy").with_code(1);
    still.run("simulate scene.toml -o none/m.json").with_code(4);
    still.run("simulate none.toml -o m.json").with_code(2);
    still.run("simulate scene.toml -o m.json --step 0").with_code(1);
    still.run("simulate scene.toml -o m.json --duration -1").with_code(1);
    let apart = folder(
        "[[objects]]\nname = \"shot\"\nshape = \"sphere\"\nbody = { linear_velocity = [1e9, 0, 0], gravity_scale = 1e9 }\n[physics]\nduration = 100\nstep = 0.1\n",
    );
    let told = apart.run("simulate scene.toml -o m.json").with_code(2).stderr;
    assert!(told.contains("the body of `shot` flew apart") && told.contains("scene.toml:"), "{told}");
    let long = apart.run("simulate scene.toml -o m.json --step 0.000001 --duration 100000").with_code(2).stderr;
    assert!(long.contains("33554432 poses"), "{long}");
    assert!(!apart.path("m.json").exists());
}

/// A scene that uses the file of a simulation is told when its physics is no longer that of the file.
#[test]
fn a_stale_motion_file_is_told() {
    let folder = folder("[physics]\nduration = 0.25\n[animation]\nkeyframes = \"m.json\"\n");
    let scene = std::fs::read_to_string(folder.path("scene.toml")).unwrap();
    let bake = |words: &str| {
        let told = folder.run(&format!("simulate scene.toml -o m.json --json --quiet {words}")).with_code(0).stdout;
        let summary: serde_json::Value = serde_json::from_str(&told).unwrap();
        summary["hash"].as_str().unwrap().to_owned()
    };
    let says = |scene: &str| {
        folder.put("scene.toml", scene);
        let still = folder.run("render scene.toml -o s.png --spp 1 --quiet").with_code(0).stderr;
        let film = folder.run("animate scene.toml -o f.%d.png --spp 1 --frames 0 --quiet").with_code(0).stderr;
        assert_eq!(still.contains("simulated of other physics"), film.contains("simulated of other physics"), "{film}");
        film
    };
    // What motion does not depend on, and what the command line said of the length and the step.
    let view =
        scene.replace("position = [0, 1, 5]", "position = [0, 1, 6]").replace("reflectance = 0.7", "reflectance = 0.6");
    for words in ["", "--duration 0.1", "--step 0.01", "--step 0.003 --duration 0.1"] {
        bake(words);
        assert_eq!(says(&view), "", "{words}");
    }
    // What it depends on: properties, shapes, where things are, the rules of all.
    let hash = bake("--step 0.01");
    for (from, to) in [
        ("restitution = 0.5", "restitution = 0.6"),
        ("radius = 0.1", "radius = 0.11"),
        ("translate = [0, 3, 0]", "translate = [0, 3, 0.1]"),
        ("max = [3, -3, 3]", "max = [3, -2.9, 3]"),
        ("duration = 0.25", "duration = 0.25\ngravity = [0, -9.8, 0]"),
    ] {
        let now = scene.replace(from, to);
        assert_ne!(now, scene, "{from}");
        let told = says(&now);
        let again = "simulate again: etendue simulate scene.toml -o m.json --step 0.01";
        for part in ["warning", "m.json:1:", &hash, again] {
            assert!(told.contains(part), "no `{part}` in {told}");
        }
        let theirs = told.split("physics is ").nth(1).unwrap().split_whitespace().next().unwrap();
        assert_eq!(theirs, bake("--step 0.01"));
        assert_eq!(says(&now), "");
        folder.put("scene.toml", &scene);
        assert_eq!(bake("--step 0.01"), hash);
    }
    // Without bodies the file is one of poses like any other.
    assert_eq!(says(&scene.replace("body = {", "#").replace("body = \"fixed\"", "")), "");
    // The command line may name the file.
    folder.put("scene.toml", scene.replace("keyframes = \"m.json\"", "").replace("radius = 0.1", "radius = 0.2"));
    let words = "animate scene.toml -o f.%d.png --spp 1 --frames 0 --quiet --keyframes m.json";
    folder.run(words).with_code(0).saying(&["simulated of other physics", "m.json:1:", &hash]);
}
