//! `etendue animate`: frames, films, resuming and ends of every kind.

mod common;

use common::{Ended, Folder};
use serde_json::Value;
use std::{fs, process::Stdio, thread, time::Duration};

/// A box that turns and rises before a camera that goes past, with a light that moves.
const MOVING: &str = r#"
[camera]
position = { keys = [[0, [0, 1, 5]], [1, [1, 1, 5]]] }
look_at = [0, 0.5, 0]

[film]
size = [24, 16]

[sampler]
spp = 4

[environment]
radiance = { keys = [[0, 0.25], [1, 0.75]] }

[animation]
fps = 10
frames = 5
shutter = [0, 0.5]

[materials.red]
type = "diffuse"
reflectance = { keys = [[0, [0.75, 0.125, 0.125]], [1, [0.125, 0.125, 0.75]]] }

[[objects]]
name = "box"
shape = "box"
material = "red"
motion = { translate = { keys = [[0, [0, 0, 0]], [1, [0, 1, 0]]] }, rotate = { axis = "y", angle = { keys = [[0, 0], [1, 360]] } } }

[[objects]]
shape = "rectangle"
size = [8, 8]
transform = [{ rotate = { axis = "x", angle = -90 } }, { translate = [0, -0.5, 0] }]

[[lights]]
position = { keys = [[0, [2, 3, 2]], [1, [-2, 3, 2]]] }
intensity = 8
"#;

fn folder() -> Folder {
    let folder = Folder::new();
    folder.put("moving.toml", MOVING);
    folder
}

/// What `--json` told, a line a frame.
fn frames(ended: &Ended) -> Vec<Value> {
    ended.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn hashes(ended: &Ended) -> Vec<String> {
    frames(ended).iter().map(|frame| frame["film_hash"].as_str().unwrap().to_owned()).collect()
}

/// The files there are but for scenes.
fn files(folder: &Folder) -> Vec<String> {
    folder.files().into_iter().filter(|name| !name.ends_with(".toml")).collect()
}

#[test]
fn a_frame_alone_is_the_frame_of_the_sequence() {
    let folder = folder();
    let all = folder.run("animate moving.toml -o f.%02d.exr --json --threads 2").with_code(0);
    let told = frames(&all);
    assert_eq!(told.len(), 5);
    assert_eq!(told[3]["frame"], 3);
    assert!((told[3]["time"].as_f64().unwrap() - 0.3).abs() < 1e-12);
    assert_eq!(told[3]["outputs"][0], "f.03.exr");
    let hashes_of_all = hashes(&all);
    let distinct: std::collections::BTreeSet<_> = hashes_of_all.iter().collect();
    assert_eq!(distinct.len(), 5);
    for (words, range) in [
        ("--frames 3-3 --threads 1", 3..4),
        ("--frames 2- --threads 3 --accel brute", 2..5),
        ("--frames 0-1 --wave 7 --tile 5", 0..2),
    ] {
        let some = folder.run(&format!("animate moving.toml -o g.%d.png --json {words}")).with_code(0);
        assert_eq!(hashes(&some), hashes_of_all[range], "{words}");
    }
    assert_eq!(files(&folder).len(), 10);
}

/// Keys at a time are what a scene says that has those values; the noise of a frame is that of its own seed.
#[test]
fn a_frame_is_a_picture_of_the_scene_at_its_time() {
    let folder = folder();
    let still = MOVING
        .replace("radiance = { keys = [[0, 0.25], [1, 0.75]] }", "radiance = 0.5")
        .replace("position = { keys = [[0, [0, 1, 5]], [1, [1, 1, 5]]] }", "position = [0.5, 1, 5]")
        .replace("position = { keys = [[0, [2, 3, 2]], [1, [-2, 3, 2]]] }", "position = [0, 3, 2]")
        .replace(
            "reflectance = { keys = [[0, [0.75, 0.125, 0.125]], [1, [0.125, 0.125, 0.75]]] }",
            "reflectance = [0.4375, 0.125, 0.4375]",
        );
    folder.put("still.toml", &still);
    let words = "--frames 5 --shutter 0,0 --json";
    let a = folder.run(&format!("animate moving.toml -o a.%d.png {words}")).with_code(0);
    let b = folder.run(&format!("animate still.toml -o b.%d.png {words}")).with_code(0);
    assert_eq!(hashes(&a), hashes(&b));
    // And at the start `etendue render` shows the same, if the noise is held.
    let held = folder.run("animate moving.toml -o c.%d.png --frames 0 --shutter 0,0 --fixed-noise --json").with_code(0);
    let render = folder.run("render moving.toml -o d.png --json").with_code(0);
    assert_eq!(render.json()["film_hash"], hashes(&held)[0]);
}

/// A still of a frame is that frame, with its motion blur; one of a time has the noise of a still.
#[test]
fn a_still_is_of_a_frame_or_of_a_time() {
    let folder = folder();
    let all = folder.run("animate moving.toml -o f.%d.png --json").with_code(0);
    for frame in [0, 3] {
        let still = folder.run(&format!("render moving.toml -o s.png -o s.exr --json --frame {frame}")).with_code(0);
        assert_eq!(still.json()["film_hash"], hashes(&all)[frame]);
        assert_eq!(folder.image("s.png").f32_channel("R"), folder.image(&format!("f.{frame}.png")).f32_channel("R"));
    }
    let held = folder.run("animate moving.toml -o h.%d.png --json --fixed-noise").with_code(0);
    let timed = folder.run("render moving.toml -o s.png --json --time 0.3").with_code(0);
    assert_eq!(timed.json()["film_hash"], hashes(&held)[3]);
    assert_ne!(timed.json()["film_hash"], hashes(&held)[2]);
    let said = "the scene moves, and this is its state at 0 s";
    assert!(!timed.stderr.contains(said));
    // Without either it is the start, and that is said, unless nobody wants to hear anything or nothing moves.
    folder.run("render moving.toml -o s.png").with_code(0).saying(&[said, "--time T or --frame K"]);
    for words in ["render moving.toml -o s.png --quiet", "render scene.toml -o s.png"] {
        assert!(!folder.run(words).with_code(0).stderr.contains("moves"), "{words}");
    }
    // Labels are those of the frame, without blur.
    folder.run("render moving.toml -o s.png --labels all --labels-format npy --frame 3").with_code(0);
    folder.run("animate moving.toml -o l.%d.png --frames 3 --labels all --labels-format npy").with_code(0);
    for label in ["object", "depth", "normal", "position"] {
        let read = |name: &str| fs::read(folder.path(&format!("{name}.{label}.npy"))).unwrap();
        assert_eq!(read("s"), read("l.3"), "{label}");
    }
    folder.run("render moving.toml --frame 1 --time 1").with_code(1);
    folder.run("render moving.toml --time nan").with_code(1);
}

#[test]
fn noise_differs_unless_it_is_held() {
    let folder = Folder::new();
    let run = |words: &str| {
        let words = format!("animate scene.toml -o f.%d.png --frames 0-2 --json {words}");
        hashes(&folder.run(&words).with_code(0))
    };
    let moving = run("");
    assert!(moving[0] != moving[1] && moving[1] != moving[2]);
    let held = run("--fixed-noise");
    assert!(held[0] == held[1] && held[1] == held[2]);
    // Nothing moves, so an open shutter changes nothing.
    assert_eq!(run("--shutter 0,0.5"), moving);
    assert_ne!(run("--seed 5"), moving);
}

/// Each for itself: the object, the camera and the light.
#[test]
fn what_moves_is_blurred_by_the_shutter() {
    let folder = folder();
    let moves = [
        ("position = { keys = [[0, [0, 1, 5]], [1, [1, 1, 5]]] }", "position = [0, 1, 5]"),
        ("position = { keys = [[0, [2, 3, 2]], [1, [-2, 3, 2]]] }", "position = [2, 3, 2]"),
        ("motion = ", "# "),
    ];
    for one in 0..moves.len() {
        let others = moves.iter().enumerate().filter(|(i, _)| *i != one);
        let scene = others.fold(MOVING.to_owned(), |scene, (_, (keys, rest))| scene.replace(keys, rest));
        folder.put("one.toml", scene);
        let [sharp, blurred] = ["0,0", "0,0.5"].map(|shutter| {
            let words = format!("animate one.toml -o f.%d.png --frames 2 --json --shutter {shutter}");
            hashes(&folder.run(&words).with_code(0))
        });
        assert_ne!(sharp, blurred, "{}", moves[one].0);
    }
}

#[test]
fn resumed_frames_are_those_that_are_not_there() {
    let folder = folder();
    let words = "animate moving.toml -o f.%d.png -o f.%d.exr --json --resume";
    let all = folder.run(words).with_code(0);
    assert!(frames(&all).iter().all(|frame| frame["resumed"] == false));
    let resumed = |ended: &Ended| -> Vec<bool> { frames(ended).iter().map(|frame| frame["resumed"] == true).collect() };
    let again = folder.run(words).with_code(0);
    assert_eq!(resumed(&again), [true; 5]);
    assert_eq!(hashes(&again), hashes(&all));
    // One file of a frame is gone, another is of some other make, another is broken.
    fs::remove_file(folder.path("f.1.exr")).unwrap();
    fs::copy(folder.path("f.0.png"), folder.path("f.2.png")).unwrap();
    fs::write(folder.path("f.3.png"), b"no picture").unwrap();
    let again = folder.run(words).with_code(0);
    assert_eq!(resumed(&again), [true, false, false, false, true]);
    assert_eq!(hashes(&again), hashes(&all));
    // Other settings make other frames, and so does another time.
    assert_eq!(resumed(&folder.run(&format!("{words} --spp 5")).with_code(0)), [false; 5]);
    assert_eq!(resumed(&folder.run(&format!("{words} --spp 5 --speed 2")).with_code(0)), [false; 5]);
    // So do another scene, and another time or shutter where the camera rests.
    let resting = MOVING.replace("position = { keys = [[0, [0, 1, 5]], [1, [1, 1, 5]]] }", "position = [0, 1, 5]");
    let mut seen = std::collections::BTreeSet::new();
    for (scene, words) in [
        (resting.clone(), words.to_owned()),
        (resting.replace("intensity = 8", "intensity = 9"), words.to_owned()),
        (resting.clone(), format!("{words} --start 0.3")),
        (resting.clone(), format!("{words} --shutter 0,0.3")),
        (resting, format!("{words} --shutter 0,0")),
    ] {
        folder.put("moving.toml", scene);
        let fresh = folder.run(&words).with_code(0);
        assert_eq!(resumed(&fresh), [false; 5], "{words}");
        assert!(seen.insert(hashes(&fresh)), "another picture: {words}");
        assert_eq!(resumed(&folder.run(&words).with_code(0)), [true; 5], "{words}");
    }
}

#[test]
fn films_are_made_of_frames_and_leave_nothing() {
    let folder = folder();
    let whole = folder.run("animate moving.toml -o film.gif -o film.png -o film.y4m --json").with_code(0);
    assert_eq!(files(&folder), ["film.gif", "film.png", "film.y4m"]);
    let read = |name: &str| fs::read(folder.path(name)).unwrap();
    assert!(read("film.gif").starts_with(b"GIF89a"));
    assert!(read("film.y4m").starts_with(b"YUV4MPEG2 W24 H16 F10:1"));
    assert_eq!(read("film.y4m").windows(5).filter(|window| window == b"FRAME").count(), 5);
    assert!(read("film.png").windows(4).any(|window| window == b"acTL"));
    // The same through a pipe, and in parts that are resumed.
    let pipe = folder.command("animate moving.toml -o - --quiet").output().unwrap();
    assert!(pipe.status.success());
    assert_eq!(pipe.stdout, read("film.y4m"));
    assert_eq!(frames(&whole).len(), 5);
    assert_eq!(frames(&whole)[0]["outputs"].as_array().unwrap().len(), 3);
}

/// A film that is whole says what it was made of, and is not made again.
#[test]
fn a_whole_film_is_not_rendered_again() {
    let folder = folder();
    let mut names = vec!["film.gif", "film.png"];
    if cfg!(feature = "h264") {
        names.push("film.mp4");
    }
    let resumed = |ended: &Ended| -> Vec<bool> { frames(ended).iter().map(|frame| frame["resumed"] == true).collect() };
    for name in &names {
        let words = format!("animate moving.toml -o {name} --json --labels object --resume");
        let all = folder.run(&words).with_code(0);
        assert_eq!(resumed(&all), [false; 5]);
        let film = fs::read(folder.path(name)).unwrap();
        let written = fs::metadata(folder.path(name)).unwrap().modified().unwrap();
        let again = folder.run(&words).with_code(0).saying(&["5 frames were there already"]);
        assert_eq!((resumed(&again), hashes(&again)), (vec![true; 5], hashes(&all)), "{name}");
        assert_eq!(frames(&again)[0]["outputs"], frames(&all)[0]["outputs"]);
        assert_eq!(fs::metadata(folder.path(name)).unwrap().modified().unwrap(), written);
        // Labels that are gone are made again, without a picture.
        fs::remove_file(folder.path(&format!("{name}.labels/frame.000002.labels.json"))).unwrap();
        let again = folder.run(&words).with_code(0).saying(&["5 frames were there already"]);
        assert_eq!((resumed(&again), hashes(&again)), (vec![true; 5], hashes(&all)), "{name}");
        assert_eq!(frames(&again)[2]["labels"].as_array().unwrap().len(), 2, "{again:?}");
        assert!(folder.path(&format!("{name}.labels/frame.000002.labels.json")).exists());
        // What makes another film is rendered; so is one that is damaged, and without --resume all is.
        for (other, count) in [("--frames 0-3", 4), ("--spp 5", 5), ("--fps 12", 5), ("--fixed-noise", 5)] {
            assert_eq!(resumed(&folder.run(&format!("{words} {other}")).with_code(0)), vec![false; count], "{other}");
        }
        folder.put(name, &film[..film.len() - 40]);
        assert_eq!(resumed(&folder.run(&words).with_code(0)), [false; 5]);
        assert_eq!(fs::read(folder.path(name)).unwrap(), film);
        assert_eq!(resumed(&folder.run(&words.replace("--resume", "")).with_code(0)), [false; 5]);
        folder.put("moving.toml", MOVING.replace("fps = 10", "fps = 10\nspeed = 2"));
        assert_eq!(resumed(&folder.run(&words).with_code(0)), [false; 5]);
        folder.put("moving.toml", MOVING);
        fs::remove_dir_all(folder.path(&format!("{name}.labels"))).unwrap();
    }
    names.sort_unstable();
    assert_eq!(files(&folder), names);
    // With others: what is whole stays, and of the rest what is missing is made.
    let words = "animate moving.toml -o film.gif -o f.%d.exr --json --resume";
    let all = folder.run(words).with_code(0);
    fs::remove_file(folder.path("f.3.exr")).unwrap();
    let again = folder.run(words).with_code(0);
    assert_eq!(resumed(&again), [true, true, true, false, true]);
    assert_eq!(hashes(&again), hashes(&all));
}

/// Without the encoder an MP4 is refused before anything is rendered, and a film without a name is a GIF.
#[cfg(not(feature = "h264"))]
#[test]
fn mp4_that_was_left_out_is_told() {
    let folder = folder();
    for name in ["film.mp4", "film.m4v"] {
        let told = folder.run(&format!("animate moving.toml -o {name} -o f.%d.png")).with_code(3);
        told.saying(&["MP4 was left out of this program", "C++ compiler", "write .gif, .apng or numbered pictures"]);
        assert_eq!(files(&folder), [""; 0]);
    }
    folder.run("animate moving.toml --quiet").with_code(0);
    assert_eq!(files(&folder), ["moving.gif"]);
}

#[cfg(feature = "h264")]
#[test]
fn a_film_of_a_bare_model_turns() {
    let folder = Folder::new();
    let cube = "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0 0 1\nv 1 0 1\nv 1 2 1\nv 0 2 1\n\
                f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    folder.put("cube.obj", cube);
    let words = "animate cube.obj --turntable=8 --size 32x24 --spp 1 --quiet --json --fixed-noise";
    let film = folder.run(words).with_code(0);
    assert_eq!(frames(&film).len(), 8);
    let bytes = fs::read(folder.path("cube.mp4")).unwrap();
    assert_eq!(&bytes[4..8], b"ftyp");
    assert_eq!(files(&folder), ["cube.mp4", "cube.obj"]);
    // Once round: the frame after the last is the first.
    let next = folder.run(&format!("{words} -o next.%d.png --frames 8")).with_code(0);
    assert_eq!(hashes(&next)[0], hashes(&film)[0]);
    assert_ne!(hashes(&film)[4], hashes(&film)[0]);
    folder.run("animate scene.toml --turntable").with_code(1).saying(&["--turntable is for models"]);
}

#[test]
fn bodies_fall() {
    let folder = Folder::new();
    let scene = r#"
        camera = { position = [0, 1, 5], look_at = [0, 1, 0] }
        film = { size = [16, 16] }
        sampler = { spp = 1 }
        environment = { radiance = 1 }
        animation = { fps = 10, duration = 0.5 }
        [[objects]]
        name = "ball"
        shape = "sphere"
        radius = 0.3
        transform = [{ translate = [0, 2, 0] }]
        body = "dynamic"
        [[objects]]
        shape = "box"
        min = [-2, -0.2, -2]
        max = [2, 0, 2]
        body = "fixed"
    "#;
    folder.put("fall.toml", scene);
    let all = folder.run("animate fall.toml -o a.%d.png --json").with_code(0);
    assert_eq!(frames(&all).len(), 5);
    let one = folder.run("animate fall.toml -o b.%d.png --json --frames 4").with_code(0);
    assert_eq!(hashes(&one)[0], hashes(&all)[4]);
    // One picture of it is that of `etendue render`.
    let still = folder.run("render fall.toml -o d.png --json --frame 3").with_code(0);
    assert_eq!(still.json()["film_hash"], hashes(&all)[3]);
    // From a file that was simulated before, the same, to the bit.
    folder.run("simulate fall.toml -o m.json --duration 0.5 --quiet").with_code(0);
    let baked = folder.run("animate fall.toml -o c.%d.png --json --keyframes m.json").with_code(0);
    assert_eq!(hashes(&baked), hashes(&all));
}

#[test]
fn mistakes_in_usage() {
    let folder = folder();
    for (words, code, parts) in [
        ("scene.toml -o f.%d.png", 1, ["nothing says how many frames", "--frames"]),
        ("moving.toml -o f.%d.png --frames 7-5", 1, ["A <= B", ""]),
        ("moving.toml -o f.%d.png --frames 5-", 1, ["ends with frame 4", ""]),
        ("moving.toml -o f.%d.png --frames 99999999999", 1, ["at most 1000000000", ""]),
        ("moving.toml -o f.exr", 1, ["one picture", "%04d"]),
        ("moving.toml -o f.%d.tiff", 1, [".png", ""]),
        ("moving.toml -o f.avi", 1, [".mp4", ""]),
        ("moving.toml -o f.%x.png", 1, ["no number of a frame", ""]),
        ("moving.toml -o f.%d.hdr --resume", 1, ["--resume", ".hdr"]),
        ("moving.toml -o - --json", 1, ["both want standard output", ""]),
        ("moving.toml -o f.%d.png --fps 0", 1, ["frames a second", ""]),
        ("moving.toml -o f.%d.png --shutter 1,0", 1, ["OPEN <= CLOSE", ""]),
        ("moving.toml -o f.gif --fps 100", 1, ["at most 50 frames a second", "--fps"]),
        ("moving.toml -o no/such/f.%d.png", 4, ["does not exist", ""]),
        ("moving.toml -o no/such/f.gif", 4, ["does not exist", ""]),
        ("moving.toml -o f.%d.png --keyframes none.json", 2, ["no such file", ""]),
        ("none.toml -o f.%d.png", 2, ["no such file", ""]),
    ] {
        folder.run(&format!("animate {words}")).with_code(code).saying(&parts);
        assert_eq!(files(&folder), [""; 0], "{words}");
    }
    // A frame far out in time is the last one.
    let far = folder.run("animate moving.toml -o f.%d.png --frames 1000000000 --json").with_code(0);
    assert_eq!(frames(&far)[0]["outputs"][0], "f.1000000000.png");
}

/// A camera without sense in a late frame is told before the first one is rendered.
#[test]
fn cameras_are_checked_before_anything_is_rendered() {
    let folder = Folder::new();
    let camera = "position = { keys = [[0, [0, 0, 5]], [1, [0, 0, -5]]] }\nlook_at = [0, 0, 0]\n";
    folder.put("s.toml", format!("[camera]\n{camera}[animation]\nfps = 10\n"));
    folder
        .run("animate s.toml -o f.%d.png")
        .with_code(2)
        .saying(&["in frame 5, at 0.5 s", "the camera's own position"]);
    assert_eq!(files(&folder), [""; 0]);
}

#[cfg(unix)]
#[test]
fn a_disk_that_is_full_ends_in_a_message_and_no_broken_frame() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    // Devices take no frames; a folder that nobody may write to is told beforehand.
    fs::create_dir(folder.path("shut")).unwrap();
    fs::set_permissions(folder.path("shut"), fs::Permissions::from_mode(0o500)).unwrap();
    let is_root = fs::write(folder.path("shut/x"), b"").is_ok();
    if !is_root {
        folder.run("animate moving.toml -o shut/f.%d.png").with_code(4);
    }
    folder.run("animate moving.toml -o /dev/full").with_code(1);
    fs::create_dir(folder.path("film.gif")).unwrap();
    folder.run("animate moving.toml -o film.gif").with_code(4).saying(&["a folder"]);
    // The frames' folder is in the way of a file.
    fs::write(folder.path("other.gif.frames"), b"x").unwrap();
    folder.run("animate moving.toml -o other.gif").with_code(4).saying(&["other.gif.frames"]);
}

#[cfg(unix)]
fn send(id: u32, signal: &str) {
    assert!(std::process::Command::new("kill").args(["-s", signal, &id.to_string()]).status().unwrap().success());
}

/// Killed at any time, a run leaves whole frames and no film; resumed, the film is that of a run that nobody killed.
#[cfg(unix)]
#[test]
fn killed_runs_leave_nothing_broken() {
    use etendue_scene::image_file::{Limits, read_image};
    let folder = folder();
    let words = "animate moving.toml -o film.gif --spp 64 --frames 0-11 --threads 1";
    let whole = folder.run(&words.replace("film.gif", "whole.gif")).with_code(0);
    assert_eq!(whole.code, 0);
    let dir = folder.path("film.gif.frames");
    let pictures = || -> Vec<_> {
        let names = fs::read_dir(&dir).into_iter().flatten().map(|entry| entry.unwrap().path());
        names.filter(|path| path.extension().is_some_and(|e| e == "png")).collect()
    };
    for (wanted, signal) in [(1, "KILL"), (3, "INT"), (5, "KILL"), (7, "TERM"), (8, "KILL")] {
        let mut child =
            folder.command(&format!("{words} --resume")).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        while pictures().len() < wanted && child.try_wait().unwrap().is_none() {
            thread::sleep(Duration::from_millis(2));
        }
        send(child.id(), signal);
        let ended = Ended::from(child.wait_with_output().unwrap(), signal);
        if signal != "KILL" && ended.code != 0 {
            ended.with_code(130).saying(&["--resume"]);
        }
        for path in pictures() {
            read_image(&path, &Limits::default()).unwrap();
        }
        if folder.path("film.gif").exists() {
            break;
        }
    }
    folder.run(&format!("{words} --resume")).with_code(0);
    assert_eq!(fs::read(folder.path("film.gif")).unwrap(), fs::read(folder.path("whole.gif")).unwrap());
    assert!(!dir.exists());
}
