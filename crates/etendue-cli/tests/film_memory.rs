//! A long film needs no more memory than a short one.
#![cfg(target_os = "linux")]

mod common;

use common::{Folder, falling, proves};
use std::{
    fs,
    io::{BufRead, BufReader},
    process::Stdio,
};

/// What the program holds from an early frame to the end grows by a hundredth, or by 2 MiB.
#[test]
fn memory_does_not_grow_from_frame_to_frame() {
    let (frames, settled) = if proves() { (1000, 100) } else { (160, 60) };
    let folder = Folder::new();
    folder.put("many.toml", falling(200, 8, [16, 9], 1, frames));
    let mut child =
        folder.command("animate many.toml -o f.%d.png --json --quiet").stdout(Stdio::piped()).spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let kibibytes = || -> f64 {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap_or("0 kB");
        line.trim().trim_end_matches(" kB").parse().unwrap()
    };
    let (mut early, mut late, mut count) = (0.0, 0.0, 0);
    for line in BufReader::new(child.stdout.take().unwrap()).lines() {
        let _: serde_json::Value = serde_json::from_str(&line.unwrap()).unwrap();
        match count {
            n if n == settled => early = kibibytes(),
            // The program may be gone after the last ones.
            n if n + 10 < frames && n > settled => late = kibibytes(),
            _ => {}
        }
        count += 1;
    }
    assert!(child.wait().unwrap().success() && count == frames && late > 0.0);
    println!("{early} kB after frame {settled}, {late} kB at the end of {frames}");
    assert!(late - early < f64::max(0.01 * early, 2048.0), "{early} kB, then {late} kB");
}
