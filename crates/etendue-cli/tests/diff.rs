//! `etendue diff`.

mod common;

use common::Folder;

/// A PFM file of 2 x 1 pixels.
fn pfm(pixels: [[f32; 3]; 2]) -> Vec<u8> {
    let mut bytes = b"PF\n2 1\n-1.0\n".to_vec();
    bytes.extend(pixels.iter().flatten().flat_map(|v| v.to_le_bytes()));
    bytes
}

#[test]
fn equal_pictures_differ_by_nothing() {
    let folder = Folder::new();
    folder.run("render scene.toml -o a.exr -o a.png -o a.pfm").with_code(0);
    for name in ["a.exr", "a.png", "a.pfm"] {
        for metric in ["relmse", "mse", "mae", "flip", "hdr-flip"] {
            let ended = folder.run(&format!("diff {name} {name} --metric {metric} --fail-above 0 --json")).with_code(0);
            assert_eq!(ended.json()["value"], 0.0);
        }
    }
    folder.run("diff a.exr a.pfm --fail-above 0").with_code(0);
    // 8 bits lose up to half a step, and what is beyond white.
    let ended = folder.run("diff a.png a.exr --metric mae --json").with_code(0);
    assert!(ended.json()["value"].as_f64().unwrap() > 0.0);
}

#[test]
fn the_second_picture_is_the_reference() {
    let folder = Folder::new();
    folder.put("a.pfm", pfm([[1.0; 3], [3.0; 3]]));
    folder.put("b.pfm", pfm([[1.0; 3], [2.0; 3]]));
    let value = |words: &str| folder.run(words).with_code(0).json()["value"].as_f64().unwrap();
    assert!((value("diff a.pfm b.pfm --json") - 0.5 / 4.01).abs() < 1e-12);
    assert!((value("diff b.pfm a.pfm --json") - 0.5 / 9.01).abs() < 1e-12);
    assert_eq!(value("diff a.pfm b.pfm --json --metric mse"), 0.5);
    assert_eq!(value("diff a.pfm b.pfm --json --metric mae"), 0.5);
    let text = folder.run("diff a.pfm b.pfm --metric mae").with_code(0).stdout;
    assert!(text.starts_with("mae 5e-1, largest 1e0 at pixel 1,0, channels R G B"), "{text}");
}

#[test]
fn flip_goes_by_the_range_of_the_reference() {
    let folder = Folder::new();
    folder.run("render scene.toml -o a.exr -o a.png --seed 1").with_code(0);
    folder.run("render scene.toml -o b.exr -o b.png -o b.hdr --seed 2").with_code(0);
    let metric =
        |words: &str| folder.run(&format!("diff {words} --metric flip --json")).with_code(0).json()["metric"].clone();
    assert_eq!(metric("a.png b.png"), "flip");
    assert_eq!(metric("a.exr b.png"), "flip");
    assert_eq!(metric("a.exr b.exr"), "hdr-flip");
    assert_eq!(metric("a.exr b.hdr"), "hdr-flip");
    let text = folder.run("diff a.png b.png --metric flip -o heat.png").with_code(0).stdout;
    assert!(text.starts_with("flip ") && text.contains("heat.png: error, bright end"), "{text}");
}

#[test]
fn limits_and_pixels_that_are_not_finite_fail_with_5() {
    let folder = Folder::new();
    folder.put("a.pfm", pfm([[1.0; 3], [3.0; 3]]));
    folder.put("b.pfm", pfm([[1.0; 3], [2.0; 3]]));
    folder.put("nan.pfm", pfm([[1.0; 3], [f32::NAN, 2.0, 2.0]]));
    folder.run("diff a.pfm b.pfm --metric mse --fail-above 0.5").with_code(0);
    let failed = folder.run("diff a.pfm b.pfm --metric mse --fail-above 0.49").with_code(5);
    assert!(failed.stdout.contains("failed"), "{failed:#?}");
    let nan = folder.run("diff nan.pfm b.pfm --fail-above 1 --json").with_code(5).json();
    assert_eq!((&nan["nonfinite"], &nan["value"]), (&1.into(), &0.0.into()));
    assert_eq!(nan["first_nonfinite"], serde_json::json!([1, 0]));
    folder.run("diff nan.pfm b.pfm").with_code(0);
}

#[test]
fn sizes_must_agree() {
    let folder = Folder::new();
    folder.put("a.pfm", pfm([[1.0; 3], [3.0; 3]]));
    folder.run("render scene.toml -o b.exr").with_code(0);
    folder.run("diff a.pfm b.exr").with_code(2).saying(&["2x1", "16x12"]);
}

#[test]
fn heat_maps_are_pictures_of_the_error() {
    let folder = Folder::new();
    folder.put("a.pfm", pfm([[1.0; 3], [3.0; 3]]));
    folder.put("b.pfm", pfm([[1.0; 3], [2.0; 3]]));
    folder.run("diff a.pfm b.pfm -o heat.png").with_code(0);
    let heat = folder.image("heat.png");
    assert_eq!((heat.width, heat.height), (2, 1));
    let red = heat.f32_channel("R").unwrap();
    assert!(red[0] < 0.01 && red[1] > 0.9, "{red:?}");
    folder.run("diff a.pfm b.pfm -o no/heat.png").with_code(4);
}
