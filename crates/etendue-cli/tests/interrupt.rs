//! Files are whole at any moment of a render, and after Ctrl-C.
#![cfg(unix)]

mod common;

use common::{Ended, Folder};
use etendue_scene::{
    image_file::{Limits, exr, read_image},
    output::hash::film_hash,
};
use std::{
    fs,
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

fn start(folder: &Folder, words: &str) -> Child {
    folder.command(words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args(["-s", name, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// Ends the child if it has not ended by itself after a generous time.
fn wait(mut child: Child, words: &str) -> Ended {
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > Duration::from_secs(120) {
            child.kill().unwrap();
        }
        thread::sleep(Duration::from_millis(20));
    }
    Ended::from(child.wait_with_output().unwrap(), words)
}

#[test]
fn refreshed_files_are_whole_and_the_first_signal_keeps_what_there_is() {
    for name in ["INT", "TERM"] {
        let folder = Folder::new();
        let words = "render scene.toml --spp 16777216 --threads 1 -o a.exr -o a.png --json";
        let child = start(&folder, words);
        let start = Instant::now();
        let mut reads = 0;
        // The first refresh comes after some seconds; from then on every look must find a whole file.
        while reads < 20 {
            assert!(start.elapsed() < Duration::from_secs(120), "no file was refreshed");
            for file in ["a.exr", "a.png"] {
                if folder.path(file).exists() {
                    read_image(&folder.path(file), &Limits::default()).unwrap();
                    reads += 1;
                }
            }
            thread::sleep(Duration::from_millis(10));
        }
        signal(&child, name);
        let ended = wait(child, words).with_code(130).saying(&["interrupted", "of 16777216"]);
        let json = ended.json();
        assert_eq!(json["interrupted"], true);
        let bytes = fs::read(folder.path("a.exr")).unwrap();
        let (image, metadata) = exr::read(&folder.path("a.exr"), &bytes, &Limits::default()).unwrap();
        assert_eq!(json["film_hash"], film_hash(&image), "the files are of the last state");
        let (low, high) = (json["spp_min"].as_u64().unwrap(), json["spp_max"].as_u64().unwrap());
        let told = if low == high { low.to_string() } else { format!("{low}-{high}") };
        assert_eq!(metadata.get("spp"), Some(&told[..]));
        let taken = json["spp"].as_f64().unwrap() * 16.0 * 12.0;
        assert_eq!(taken.round() as u64, json["paths"].as_u64().unwrap());
        assert!(low > 0 && high < 16_777_216, "{json}");
        assert_eq!(folder.files(), ["a.exr", "a.png"], "no parts are left behind");
    }
}

#[test]
fn what_an_interruption_keeps_is_the_same_as_a_shorter_render() {
    // One tile: every pixel has the same number of samples, a whole number of blocks.
    let folder = Folder::new();
    let words = "render scene.toml --spp 16777216 --threads 1 --tile 64 -o a.exr --json";
    let child = start(&folder, words);
    let start = Instant::now();
    while !folder.path("a.exr").exists() {
        assert!(start.elapsed() < Duration::from_secs(120));
        thread::sleep(Duration::from_millis(20));
    }
    signal(&child, "INT");
    let json = wait(child, words).with_code(130).json();
    assert_eq!(json["spp_min"], json["spp_max"]);
    let again = folder.run(&format!("render scene.toml --spp {} -o b.exr --json", json["spp_min"])).with_code(0);
    assert_eq!(again.json()["film_hash"], json["film_hash"]);
}

/// A render that outlives its terminal still ends neatly when it is told to.
#[test]
fn nohup_keeps_a_render_from_hanging_up_and_from_nothing_else() {
    let folder = Folder::new();
    let words = "render scene.toml --spp 16777216 --threads 1 -o a.exr --json";
    let etendue = folder.command(words);
    let mut shell = Command::new("sh");
    shell.args(["-c", "trap '' HUP; exec \"$0\" \"$@\""]).arg(etendue.get_program()).args(etendue.get_args());
    if let Some(directory) = etendue.get_current_dir() {
        shell.current_dir(directory);
    }
    let mut child = shell.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    while !folder.path("a.exr").exists() {
        assert!(start.elapsed() < Duration::from_secs(120), "no file was refreshed");
        thread::sleep(Duration::from_millis(20));
    }
    signal(&child, "HUP");
    thread::sleep(Duration::from_millis(300));
    assert!(child.try_wait().unwrap().is_none(), "a hang-up ended it");
    signal(&child, "TERM");
    assert_eq!(wait(child, words).with_code(130).json()["interrupted"], true);
}

#[test]
fn signals_in_a_row_end_the_program_at_once() {
    // One unit of work takes much longer than the wait between signals, so that the second ends this, not the first.
    let folder = Folder::new();
    let words = "render scene.toml --size 2048x2048 --tile 2048 --spp 16 --threads 1 -o a.exr";
    let mut child = start(&folder, words);
    let start = Instant::now();
    // A signal that comes before the program listens just kills it; the first refreshed file shows that it renders.
    while !folder.path("a.exr").exists() {
        assert!(start.elapsed() < Duration::from_secs(120), "no file was refreshed");
        thread::sleep(Duration::from_millis(20));
    }
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        assert!(start.elapsed() < Duration::from_secs(60), "still running");
        signal(&child, "INT");
        thread::sleep(Duration::from_millis(200));
    }
    assert_eq!(child.wait().unwrap().code(), Some(130));
}
