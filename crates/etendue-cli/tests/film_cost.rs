//! 200 bodies in a film: what is not rendering takes little of the time.

mod common;

use common::{Folder, falling, proves};

/// Reading the scene, simulating it and bringing it from frame to frame, beside rendering.
#[test]
fn loading_and_rebuilding_take_little_time() {
    let folder = Folder::new();
    // Of a small picture the share is larger.
    let (size, spp, frames, most) = if proves() { ([640, 360], 32, 100, 0.05) } else { ([160, 90], 8, 6, 0.35) };
    folder.put("many.toml", falling(200, 8, size, spp, frames));
    let ended = folder.run("animate many.toml -o f.%d.png --stats").with_code(0);
    let seconds = |name: &str| -> f64 {
        let line = ended.stderr.lines().find(|line| line.starts_with(name)).unwrap();
        line.split_whitespace().nth(1).unwrap().parse().unwrap()
    };
    let [load, rebuild, render] = ["load", "rebuild", "render"].map(seconds);
    let share = (load + rebuild) / (load + rebuild + render);
    println!("{frames} frames: load {load} s, rebuild {rebuild} s, render {render} s: {:.2} %", 100.0 * share);
    assert!(share < most, "{share}");
}
