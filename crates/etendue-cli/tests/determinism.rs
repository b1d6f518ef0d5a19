//! The picture depends on scene, settings and seed, never on threads, accelerator, instruction set, tile or wave; and a
//! crop is the crop of the whole.

mod common;

use common::{Folder, shipped};
use etendue::image::ChannelData;
use etendue_accel::Isa;

/// Scenes that ship with the project: a box, glass with spheres and instances, a mesh, a lens with rough metal, textures,
/// brushed metal, a sky, media in bodies within each other.
const SCENES: [&str; 8] =
    ["cornell-box", "glass-spheres", "mesh", "lens-metal", "still-life", "brushed-metal", "daylight", "fog"];

/// All layers, so that the hash covers them.
const LAYERS: &str = "--aov albedo,normal,depth,ids,variance";

/// Size and samples; `ETENDUE_PROVE=1` asks for more.
fn effort() -> &'static str {
    if std::env::var("ETENDUE_PROVE").is_ok_and(|v| v == "1") {
        "--size 160x120 --spp 16"
    } else {
        "--size 24x18 --spp 3"
    }
}

/// The same where every ray tests every triangle.
fn small_effort() -> &'static str {
    if std::env::var("ETENDUE_PROVE").is_ok_and(|v| v == "1") { "--size 24x18 --spp 3" } else { "--size 8x6 --spp 2" }
}

fn hash(folder: &Folder, scene: &str, words: &str) -> String {
    let scene = shipped(scene);
    let words = format!("render {scene} --json --quiet -o a.exr {LAYERS} {words}");
    folder.run(&words).with_code(0).json()["film_hash"].as_str().unwrap().to_owned()
}

/// Every way gives the hash of one thread, and another seed another.
fn compare(effort: &str, ways: &[String]) {
    let folder = Folder::new();
    for scene in SCENES {
        let expected = hash(&folder, scene, &format!("{effort} --threads 1"));
        for way in ways {
            assert_eq!(hash(&folder, scene, &format!("{effort} {way}")), expected, "{scene} {way}");
        }
        let other = hash(&folder, scene, &format!("{effort} --seed 12345"));
        assert_ne!(other, expected, "{scene}: the hash sees the picture");
    }
}

#[test]
fn one_hash_for_threads_trees_tiles_waves_and_instruction_sets() {
    let mut ways: Vec<String> = [
        "--threads 2",
        "--threads 7",
        "--accel kdtree",
        "--accel kdtree-midpoint",
        "--tile 1",
        "--tile 5",
        "--tile 4096",
        "--wave 1",
        "--wave 37",
        "--wave 4096",
        "--threads 7 --accel kdtree --tile 3 --wave 11",
    ]
    .map(str::to_owned)
    .into();
    for isa in Isa::available() {
        ways.extend(["bvh", "kdtree"].map(|accel| format!("--threads 2 --accel {accel} --isa {isa}")));
    }
    compare(effort(), &ways);
}

#[test]
fn one_hash_for_brute_force_too() {
    let ways: Vec<String> =
        Isa::available().iter().map(|isa| format!("--threads 2 --accel brute --isa {isa}")).collect();
    compare(small_effort(), &ways);
}

#[test]
fn a_crop_is_the_crop_of_the_whole() {
    let folder = Folder::new();
    let [x0, y0, x1, y1] = [5_usize, 3, 19, 14];
    for scene in SCENES {
        hash(&folder, scene, effort());
        let whole = folder.image("a.exr");
        hash(&folder, scene, &format!("{} --crop {x0},{y0},{x1},{y1} --tile 4 --threads 2", effort()));
        let crop = folder.image("a.exr");
        assert_eq!((crop.width as usize, crop.height as usize), (x1 - x0, y1 - y0));
        assert_eq!(crop.channels.len(), whole.channels.len());
        for (whole_channel, crop_channel) in whole.channels.iter().zip(&crop.channels) {
            assert_eq!(whole_channel.name, crop_channel.name);
            let expected: Vec<u32> = (y0..y1)
                .flat_map(|y| (x0..x1).map(move |x| (x, y)))
                .map(|(x, y)| bits(&whole_channel.data)[y * whole.width as usize + x])
                .collect();
            assert_eq!(bits(&crop_channel.data), expected, "{scene} {}", crop_channel.name);
        }
    }
}

fn bits(data: &ChannelData) -> Vec<u32> {
    match data {
        ChannelData::F32(data) => data.iter().map(|v| v.to_bits()).collect(),
        ChannelData::U32(data) => data.clone(),
    }
}
