//! Ten thousand bodies end in a film.

mod common;

use common::{Folder, falling, proves};
use serde_json::Value;
use std::{fs, time::Instant};

/// None is lost, and the film is whole.
#[test]
fn many_bodies_become_a_film() {
    let folder = Folder::new();
    let (count, side, frames) = if proves() { (10_000, 20, 26) } else { (1500, 12, 11) };
    folder.put("heap.toml", falling(count, side, [96, 64], 4, frames));
    let clock = Instant::now();
    let ended = folder.run("animate heap.toml -o heap.png --fps 25 --json --stats").with_code(0);
    println!("{count} bodies, {frames} frames: {:.1} s\n{}", clock.elapsed().as_secs_f64(), ended.stderr);
    let told: Vec<Value> = ended.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(told.len(), frames as usize);
    assert!(told.windows(2).all(|pair| pair[0]["film_hash"] != pair[1]["film_hash"]));
    let film = fs::read(folder.path("heap.png")).unwrap();
    let control = film.windows(4).position(|window| window == b"acTL").unwrap();
    assert_eq!(film[control + 4..control + 8], frames.to_be_bytes());

    // Where they are in the end: nothing has fallen through the floor or flown away.
    let seconds = f64::from(frames - 1) / 25.0;
    folder.run(&format!("simulate heap.toml -o heap.json --duration {seconds} --quiet")).with_code(0);
    let motion: Value = serde_json::from_slice(&fs::read(folder.path("heap.json")).unwrap()).unwrap();
    let objects = motion["objects"].as_array().unwrap();
    assert_eq!(objects.len(), count as usize);
    let mut lowest = f64::INFINITY;
    for object in objects {
        let at = |point: &Value| [0, 1, 2].map(|axis| point[axis].as_f64().unwrap());
        // Poses turn about the world's origin; the pivot shows where the body is.
        let last = |key: &str| object[key].as_array().unwrap().last().unwrap().clone();
        let [x, y, z] = turned(last("rotations"), at(&object["pivot"]));
        let [a, b, c] = at(&last("positions"));
        let place = [x + a, y + b, z + c];
        assert!(place.iter().all(|v| v.abs() < 60.0), "{} is at {place:?}", object["name"]);
        lowest = lowest.min(place[1]);
    }
    println!("lowest centre {lowest} m");
    assert!(lowest > 0.1, "{lowest}");
}

/// A point turned by a quaternion `[x, y, z, w]`.
fn turned(rotation: Value, [px, py, pz]: [f64; 3]) -> [f64; 3] {
    let [x, y, z, w] = [0, 1, 2, 3].map(|i| rotation[i].as_f64().unwrap());
    let cross = |[a, b, c]: [f64; 3]| [y * c - z * b, z * a - x * c, x * b - y * a];
    let [tx, ty, tz] = cross([px, py, pz]).map(|v| 2.0 * v);
    let [ux, uy, uz] = cross([tx, ty, tz]);
    [px + w * tx + ux, py + w * ty + uy, pz + w * tz + uz]
}
