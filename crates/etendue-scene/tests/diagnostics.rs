//! What the reader of scene files says, with places and suggestions.

use etendue_scene::{Diagnostics, SourceMap, read_toml};
use std::path::Path;

fn read(text: &[u8]) -> (bool, Vec<String>) {
    let mut sources = SourceMap::new();
    let file = sources.insert("s.toml", text.to_vec()).unwrap();
    let (description, diagnostics) = read_toml(file, text, Path::new(""));
    (description.is_some(), diagnostics.iter().map(|d| d.one_line(&sources)).collect())
}

/// All findings in a text.
#[track_caller]
fn says(text: &str, expected: &[&str]) {
    let (_, found) = read(text.as_bytes());
    assert_eq!(found, expected, "\n{}", found.join("\n"));
}

/// All findings in a text that follows a good camera in line 1.
#[track_caller]
fn body_says(text: &str, expected: &[&str]) {
    says(&format!("camera = {{ position = [0, 0, 5], look_at = [0, 0, 0] }}\n{text}"), expected);
}

#[test]
fn the_smallest_scene() {
    body_says("", &[]);
    let (good, _) = read(b"camera = { position = [0, 0, 5], direction = [0, 0, -1] }");
    assert!(good);
}

#[test]
fn an_empty_file() {
    says("", &["s.toml:1:1: error: the scene file needs `camera`"]);
}

#[test]
fn misspelt_keys() {
    says(
        "[camera]\npostion = [0, 0, 5]\nlook_at = [0, 0, 0]\nlookat = 1\n[flim]\nsize = [1, 1]\n[sampler]\nbrightness = 2\n",
        &[
            "s.toml:1:1: error: [camera] needs `position`",
            "s.toml:2:1: error: unknown key `postion` in [camera]; did you mean `position`?",
            "s.toml:4:1: error: unknown key `lookat` in [camera]; did you mean `look_at`?",
            "s.toml:5:2: error: unknown key `flim` in the scene file; did you mean `film`?",
            "s.toml:8:1: error: unknown key `brightness` in [sampler]; the keys here are `type`, `spp`, `seed`",
        ],
    );
}

#[test]
fn keys_of_another_type() {
    body_says(
        "[materials.m]\ntype = \"mirror\"\nalpha = 0.1\n[[objects]]\nshape = \"sphere\"\nsize = 2",
        &[
            "s.toml:4:1: error: `alpha` is not a key of type `mirror`; it belongs to `rough-metal`, `rough-glass`, `mtl`",
            "s.toml:7:1: error: `size` is not a key of shape `sphere`; it belongs to `rectangle`, `box`",
        ],
    );
}

#[test]
fn wrong_types() {
    body_says(
        "[film]\nsize = 512\nexposure = \"bright\"\naovs = \"depth\"\n[sampler]\nspp = 1.5\n[integrator]\ntype = 7\n\
         [materials]\nm = 3\n[objects]\nshape = \"box\"\n[[environment]]\nradiance = 1\n[lights]\nx = 1979-05-27\n",
        &[
            "s.toml:3:8: error: `size` must be an array of 2 whole numbers (this is an integer)",
            "s.toml:4:12: error: `exposure` must be a number (this is a string)",
            "s.toml:5:8: error: `aovs` must be an array of names (this is a string)",
            "s.toml:7:7: error: `spp` must be a whole number (this is a number)",
            "s.toml:9:8: error: `type` must be one of `path`, `light-split`, `brute`, `normal`, `uv`, `depth`, `ids`, `ao` \
             (this is an integer)",
            "s.toml:11:5: error: `m` must be a table (this is an integer); write [materials.NAME]",
            "s.toml:12:1: error: `objects` must be an array of tables (this is a table); write [[objects]]",
            "s.toml:14:1: error: `environment` must be a table (this is an array); write [environment]",
            "s.toml:16:1: error: `lights` must be an array of tables (this is a table); write [[lights]]",
        ],
    );
}

#[test]
fn ranges_nan_and_infinity() {
    says(
        "[camera]\nposition = [0, nan, inf]\ndirection = [0, 0, 0]\nfov = 180\nlens_radius = -1\nfocus_distance = 0\n\
         [film]\nsize = [0, 100000]\n[sampler]\nspp = 0\nseed = -1\n[materials.m]\ntype = \"diffuse\"\n\
         reflectance = [0.5, 1.5, -0.1]\nopacity = 1e999\n[environment]\nradiance = 99999999999999999999\n",
        &[
            "s.toml:2:16: error: `position` is NaN (expected a finite number)",
            "s.toml:2:21: error: `position` is inf (expected a finite number)",
            "s.toml:3:13: error: `direction` is zero (expected a direction)",
            "s.toml:4:7: error: `fov` is out of range: 180 (must be above 0 and below 180)",
            "s.toml:5:15: error: `lens_radius` is out of range: -1 (must be at least 0 and at most 1e15)",
            "s.toml:6:18: error: `focus_distance` is out of range: 0 (must be above 0 and at most 1e15)",
            "s.toml:8:9: error: `size` is out of range: 0 (must be from 1 to 65536)",
            "s.toml:8:12: error: `size` is out of range: 100000 (must be from 1 to 65536)",
            "s.toml:10:7: error: `spp` is out of range: 0 (must be from 1 to 16777216)",
            "s.toml:11:8: error: `seed` is out of range: -1 (must be from 0 to 9223372036854775807)",
            "s.toml:14:21: error: `reflectance` is out of range: 1.5 (must be at least 0 and at most 1)",
            "s.toml:14:26: error: `reflectance` is out of range: -0.1 (must be at least 0 and at most 1)",
            "s.toml:15:11: error: the number is too large for 64-bit floating point",
            "s.toml:17:12: error: the integer does not fit in 64 bits",
        ],
    );
}

#[test]
fn missing_references() {
    body_says(
        "[materials.gold]\ntype = \"rough-metal\"\nmetal = \"gold\"\n[meshes.bunny]\nfile = \"b.obj\"\n\
         [[objects]]\nmesh = \"buny\"\nmaterial = \"glod\"\nname = \"a\"\n\
         [[objects]]\nmesh = \"dragon\"\nmaterial = \"silver\"\nname = \"a\"\n",
        &[
            "s.toml:8:8: error: no mesh is called `buny`; did you mean `bunny`?",
            "s.toml:9:12: error: no material is called `glod`; did you mean `gold`?",
            "s.toml:12:8: error: no mesh is called `dragon`; define it in [meshes.NAME]",
            "s.toml:13:12: error: no material is called `silver`; define it in [materials.NAME]",
            "s.toml:14:8: error: two objects are called `a`",
        ],
    );
}

#[test]
fn missing_keys() {
    body_says(
        "[materials.a]\nreflectance = 1\n[materials.b]\ntype = \"rough-metal\"\n[materials.c]\ntype = \"rough-metal\"\neta = 1\n\
         [materials.d]\ntype = \"black\"\nemission = { two_sided = true }\n[meshes.m]\n[[objects]]\n[[objects]]\nshape = \"mesh\"\n\
         [[objects]]\nshape = \"rectangle\"\nu = [1, 0, 0]\n[[lights]]\n[environment]\n",
        &[
            "s.toml:2:1: error: [materials.NAME] needs `type`",
            "s.toml:4:1: error: [materials.NAME] of type `rough-metal` needs `metal`, or `eta` and `k`",
            "s.toml:6:1: error: [materials.NAME] of type `rough-metal` needs `k`",
            "s.toml:11:12: error: emission needs `radiance`",
            "s.toml:12:1: error: [meshes.NAME] needs `file`, or `positions` and `indices`",
            "s.toml:13:1: error: [[objects]] needs `shape`",
            "s.toml:14:1: error: [[objects]] of shape `mesh` needs `mesh` or `file`",
            "s.toml:16:1: error: [[objects]] of shape `rectangle` needs `corner`",
            "s.toml:16:1: error: [[objects]] of shape `rectangle` needs `v`",
            "s.toml:19:1: error: [[lights]] needs `position`",
            "s.toml:19:1: error: [[lights]] needs `intensity`",
            "s.toml:20:1: error: [environment] needs `radiance`",
        ],
    );
}

#[test]
fn choices_and_colours() {
    body_says(
        "[film]\nfilter = \"gausian\"\ntonemap = { }\naovs = [\"depth\", \"depht\", \"depth\"]\n[accelerator]\ntype = \"kdtre\"\n\
         [materials.m]\ntype = \"rough-metal\"\nmetal = \"glod\"\ntint = \"#12345\"\n",
        &[
            "s.toml:3:10: error: `filter` has no `gausian` (expected one of `gaussian`, `box`, `tent`, `mitchell`, `lanczos`); did you mean `gaussian`?",
            "s.toml:4:11: error: `tonemap` must be one of `none`, `reinhard`, `aces`, `agx` (this is a table)",
            "s.toml:5:18: error: `aovs` has no `depht` (expected one of `albedo`, `normal`, `depth`, `position`, `uv`, `direct`, `indirect`, `alpha`, `ids`, `samples`, `variance`); did you mean `depth`?",
            "s.toml:5:27: error: layer `depth` is named twice (keep one of them)",
            "s.toml:7:8: error: `type` has no `kdtre` (expected one of `bvh`, `kdtree`, `brute`); did you mean `kdtree`?",
            "s.toml:10:9: error: no metal is called `glod` (expected one of `silver`, `gold`, `copper`, `aluminium`, `iron`, `chromium`, `titanium`, `nickel`, `cobalt`, `palladium`); did you mean `gold`?",
            "s.toml:11:8: error: `tint` is not a colour: `#12345` (expected `#rrggbb`, a number or [r, g, b])",
        ],
    );
}

#[test]
fn what_cannot_be() {
    says(
        "[camera]\nposition = [0, 5, 0]\nlook_at = [0, 0, 0]\ndirection = [0, -1, 0]\n[film]\ncrop = [0, 0, 600, 10]\n\
         [materials.m]\ntype = \"diffuse\"\nreflectance = 0.6\ntransmittance = 0.5\n\
         [materials.n]\ntype = \"rough-metal\"\nmetal = \"gold\"\neta = 1\nk = 1\n\
         [[objects]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [1, 0, 1]\n[[objects]]\nshape = \"rectangle\"\n\
         corner = [0, 0, 0]\nu = [1, 0, 0]\nv = [-2, 0, 0]\nsize = [1, 1]\n[meshes.m]\nfile = \"a.ply\"\npositions = []\n",
        &[
            "s.toml:1:1: error: `up` is parallel to the view direction (give an `up` across the view)",
            "s.toml:4:1: error: `look_at` and `direction` exclude each other; keep one of them",
            "s.toml:6:8: error: `crop` is empty or leaves the picture (the picture is 512 x 512)",
            "s.toml:9:1: error: material `m`: `reflectance + transmittance` sum to 1.1 in one channel, which is more light than arrives",
            "s.toml:14:1: error: `metal` and `eta` exclude each other; keep one of them",
            "s.toml:15:1: error: `metal` and `k` exclude each other; keep one of them",
            "s.toml:19:7: error: `max` must be above `min` on every axis (not above `min`)",
            "s.toml:22:1: error: `size` and `corner` exclude each other; keep one of them",
            "s.toml:23:1: error: `size` and `u` exclude each other; keep one of them",
            "s.toml:24:1: error: `size` and `v` exclude each other; keep one of them",
            "s.toml:24:5: error: `v` is parallel to `u` (expected an edge across `u`)",
            "s.toml:28:1: error: `file` and `positions` exclude each other; keep one of them",
        ],
    );
}

#[test]
fn transforms() {
    body_says(
        "[[objects]]\nshape = \"box\"\ntransform = [\n  { translate = [1, 2, 3], scale = 2 },\n  { scale = [1, 0, 1] },\n  {},\n\
         \x20 { rotate = { axis = \"w\", angle = 3 } },\n  { rotate = { axis = [0, 0, 0] } },\n  { matrix = [1, 2, 3] },\n\
         \x20 { matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0]] },\n  { matrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,2] },\n\
         \x20 { look_at = { position = [0, 0, 0], target = [0, 9, 0] } },\n  { tranlate = [0, 0, 0] },\n  7,\n]\n",
        &[
            "s.toml:5:3: error: a step of `transform` has 2 keys; write each step as a table of its own: their order matters",
            "s.toml:6:13: error: a scale of 0 flattens the object (expected factors other than 0)",
            "s.toml:7:3: error: a step of `transform` has 0 keys; write each step as a table of its own: their order matters",
            "s.toml:8:23: error: `axis` has no `w` (expected one of `x`, `y`, `z`)",
            "s.toml:9:14: error: rotate needs `angle`",
            "s.toml:9:23: error: `axis` is zero (expected a direction)",
            "s.toml:10:14: error: `matrix` must be 12 or 16 numbers, row by row (expected 12 or 16 numbers, row by row)",
            "s.toml:11:14: error: the matrix cannot be inverted (it flattens the object)",
            "s.toml:12:14: error: `matrix` is not affine (its last row must be 0, 0, 0, 1)",
            "s.toml:13:15: error: `target` is at `position`, or the view is parallel to `up` (give another `up` or `target`)",
            "s.toml:14:5: error: unknown key `tranlate` in a step of transform; did you mean `translate`?",
            "s.toml:15:3: error: `transform` must be a table (this is an integer); write { translate = [1, 2, 3] }",
        ],
    );
}

#[test]
fn inline_meshes() {
    body_says(
        "[meshes.m]\npositions = [[0, 0, 0], [1, 0], [0, 1, true]]\nindices = [[0, 1, 2], [0, 1, 3], [0, 1], [0, -1, 2, 1.5]]\n\
         [meshes.n]\npositions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\nindices = [[0, 1, 3]]\nnormals = [[0, 0, 1]]\nuvs = [1]\n",
        &[
            "s.toml:3:25: error: `positions` must be an array of 3 numbers, but has 2 items (expected an array of 3 numbers)",
            "s.toml:3:40: error: `positions` must be a number (this is a boolean)",
            "s.toml:4:34: error: a face has 2 corners (expected 3 or 4 vertex indices)",
            "s.toml:4:46: error: `indices` is out of range: -1 (must be from 0 to 4294967295)",
            "s.toml:4:53: error: `indices` must be a whole number (this is a number)",
            "s.toml:7:19: error: no vertex 3 (`positions` has vertices 0 to 2)",
            "s.toml:8:11: error: `normals` has 1 entries, `positions` has 3 (expected one for each vertex)",
            "s.toml:9:8: error: `uvs` must be an array of 2 numbers (this is an integer)",
        ],
    );
}

#[test]
fn syntax_errors_do_not_hide_what_follows() {
    says(
        "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\nfov 40\n[materials.a]\ntype = diffuse\n\n[film\nsize = [1, 2]\n\
         [sampler]\nspp = 1.2.3\nsed = 4\n[materials.b]\ntype = \"mirror\"\nreflectance = [1, 2\n[[objects]]\nshape = \"spere\"\n\
         [materials.b]\ntype = \"glass\"\n[environment]\nradiance = 1 2\n",
        &[
            "s.toml:4:5: error: key with no value, expected `=` (TOML syntax)",
            "s.toml:6:8: error: string values must be quoted, expected literal string (TOML syntax)",
            "s.toml:8:6: error: unclosed table, expected `]` (TOML syntax)",
            "s.toml:11:10: error: invalid float, expected nothing (TOML syntax)",
            "s.toml:12:1: error: unknown key `sed` in [sampler]; did you mean `seed`?",
            "s.toml:15:20: error: missing comma between array elements, expected `,` (TOML syntax)",
            "s.toml:17:9: error: `shape` has no `spere` (expected one of `mesh`, `sphere`, `rectangle`, `box`, `disk`); did you mean `sphere`?",
            "s.toml:18:12: error: `b` is defined twice (TOML syntax)",
            "s.toml:21:12: error: string values must be quoted, expected literal string (TOML syntax)",
        ],
    );
}

#[test]
fn one_statement_with_several_syntax_errors() {
    body_says(
        "[meshes.m]\npositions = [\n  [0, 0, x],\n  [1, 0, 0],\n  [0, 1.1.1, 0],\n]\nindces = []\n[film\n",
        &[
            "s.toml:4:10: error: string values must be quoted, expected literal string (TOML syntax)",
            "s.toml:6:10: error: invalid float, expected nothing (TOML syntax)",
            "s.toml:8:1: error: unknown key `indces` in [meshes.NAME]; did you mean `indices`?",
            "s.toml:9:6: error: unclosed table, expected `]` (TOML syntax)",
        ],
    );
}

#[test]
fn bytes_that_are_not_text() {
    let (good, found) = read(b"[camera]\nposition = [0, 0, 5] # caf\xe9\nlook_at = [0, 0, 0]\nfof = 3\n");
    assert!(!good);
    assert_eq!(
        found,
        [
            "s.toml:2:27: error: not UTF-8; save the file in the encoding UTF-8",
            "s.toml:4:1: error: unknown key `fof` in [camera]; did you mean `fov`?"
        ]
    );
    assert!(read(b"\xef\xbb\xbfcamera = { position = [0, 0, 5], look_at = [0, 0, 0] }\r\n").0);
}

#[test]
fn findings_are_bounded() {
    let many =
        format!("camera = {{ position = [0, 0, 5], look_at = [0, 0, 0] }}\n{}", "[[objects]]\nshap = 1\n".repeat(5000));
    let (good, found) = read(many.as_bytes());
    assert!(!good);
    assert_eq!(found.len(), Diagnostics::KEPT);
}

#[test]
fn deep_nesting() {
    for (open, close) in [("[", "]"), ("{a=", "}"), ("a.", "=1"), ("[[", "]]"), ("{a.b.c.d.e=", "}")] {
        for depth in [40, 79, 81, 10_000] {
            let text = format!("x = {}1{}", open.repeat(depth), close.repeat(depth));
            assert!(!read(text.as_bytes()).0);
            let text = format!("{}1{}", open.repeat(depth), close.repeat(depth));
            assert!(!read(text.as_bytes()).0);
        }
    }
    let dotted = "a.".repeat(78) + "a = {";
    let text = format!("{}x = 1{}", dotted.repeat(78), "}".repeat(78));
    assert!(!read(text.as_bytes()).0);
}

#[test]
fn lenses_that_contradict_themselves() {
    let camera = |keys: &str| format!("[camera]\nposition = [0, 0, 1]\ndirection = [0, 0, -1]\n{keys}");
    says(
        &camera(
            "focal_length = 50\nfov = 30\nlens_radius = 0.1\nf_number = 2\nfocus_distance = 1\nfocus_point = [0, 0, 0]",
        ),
        &[
            "s.toml:5:1: error: `focal_length` and `fov` exclude each other; keep one of them",
            "s.toml:7:1: error: `lens_radius` and `f_number` exclude each other; keep one of them",
            "s.toml:9:1: error: `focus_distance` and `focus_point` exclude each other; keep one of them",
        ],
    );
    says(
        &camera("sensor = 36\nf_number = 2\nblades = 5\naperture = \"square\""),
        &[
            "s.toml:1:1: error: [camera] needs `focal_length` for its `sensor`",
            "s.toml:1:1: error: [camera] needs `focal_length` for its `f_number`",
            "s.toml:6:10: error: `blades` belongs to `polygon` (leave it out, or set `aperture` to `polygon`)",
        ],
    );
    says(
        &camera("lens_radius = 1"),
        &["s.toml:1:1: error: [camera] needs `focus_distance`, `focus_point` or `focus_object` for its lens, \
           or `look_at` instead of `direction`"],
    );
    says(
        "[camera]\ntype = \"orthographic\"\nposition = [0, 0, 1]\ndirection = [0, 0, -1]\nheight = 1\nblades = 5\n",
        &["s.toml:6:1: error: `blades` is not a key of type `orthographic`; it belongs to `perspective`"],
    );
}

#[test]
fn suns_of_skies() {
    body_says(
        "[environment]\ntype = \"sky\"\nsun = [0, 1, 0]\nelevation = 100\nturbidity = 0.5\nup = \"z\"\nnorth = [0, 0, 2]\n\
         ground = 2\nsun_disk = 1\nradiance = 3",
        &[
            "s.toml:5:1: error: `sun` and `elevation` exclude each other; keep one of them",
            "s.toml:5:13: error: `elevation` is out of range: 100 (must be at least -90 and at most 90)",
            "s.toml:6:13: error: `turbidity` is out of range: 0.5 (must be at least 1 and at most 10)",
            "s.toml:8:9: error: `north` points up or down (expected a direction across z)",
            "s.toml:9:10: error: `ground` is out of range: 2 (must be at least 0 and at most 1)",
            "s.toml:10:12: error: `sun_disk` must be true or false (this is an integer)",
            "s.toml:11:1: error: `radiance` is not a key of type `sky`; it belongs to `constant`",
        ],
    );
}

#[test]
fn dates_of_skies() {
    let sky = |keys: &str| format!("[environment]\ntype = \"sky\"\n{keys}");
    for good in [
        "date = 2024-06-21\ntime = 14:30:00\nlatitude = 1\nlongitude = 2",
        "date = \"2024-06-21\"\ntime = \"24:00\"\nlatitude = 1\nlongitude = 2",
        "date = \"2024-02-29\"\nlatitude = 1\nlongitude = 2\nutc_offset = -11.5",
        "",
    ] {
        body_says(&sky(good), &[]);
    }
    let place = "latitude = 1\nlongitude = 2";
    for (bad, said) in [
        (
            "date = \"yesterday\"",
            "s.toml:4:8: error: `date` is not a date (expected year, month and day such as \"2024-06-21\")",
        ),
        (
            "date = \"2023-02-29\"",
            "s.toml:4:8: error: `date` is not in the calendar (expected a day of the years 1600 to 2400)",
        ),
        ("date = 7", "s.toml:4:8: error: `date` must be a date or time (this is an integer); write \"2024-06-21\""),
        (
            "date = 2024-06-21\ntime = \"25:00\"",
            "s.toml:5:8: error: `time` is not a time of day (expected hours and minutes such as \"14:30\")",
        ),
        (
            "date = 2024-06-21\ntime = \"1:2:3.\u{e9}\u{e9}\u{e9}\u{e9}\"",
            "s.toml:5:8: error: `time` is not a time of day (expected hours and minutes such as \"14:30\")",
        ),
    ] {
        body_says(&sky(&format!("{bad}\n{place}")), &[said]);
    }
    body_says(
        &sky("date = 2024-06-21\nlatitude = 5"),
        &["s.toml:2:1: error: [environment] of type `sky` needs `longitude` for its `date`"],
    );
    body_says(
        &sky("time = \"12:00\""),
        &["s.toml:2:1: error: [environment] of type `sky` needs `date` for its `time`"],
    );
}

#[test]
fn textures_of_textures() {
    let part =
        |name: &str, of: &str| format!("[textures.{name}]\ntype = \"multiply\"\ncolor1 = {{ texture = \"{of}\" }}\n");
    // A chain of eight, and one more.
    let mut chain = String::new();
    for i in 0..8 {
        chain += &part(&format!("t{i}"), &format!("t{}", i + 1));
    }
    chain += "[textures.t8]\ntype = \"checker\"\n";
    body_says(&chain, &["s.toml:2:11: error: texture `t0` is nested more than 8 deep; mix fewer textures"]);
    body_says(&chain.split_once("[textures.t1]").map(|(_, rest)| format!("[textures.t1]{rest}")).unwrap(), &[]);
    let circle = [part("a", "b"), part("b", "c"), part("c", "b"), part("d", "d"), part("e", "a")].concat();
    body_says(
        &format!("{circle}[materials.m]\ntype = \"diffuse\"\nreflectance = {{ texture = \"e\" }}\n"),
        &[
            "s.toml:5:11: error: textures are made of each other: b -> c -> b; a texture cannot be a part of itself",
            "s.toml:11:11: error: textures are made of each other: d -> d; a texture cannot be a part of itself",
        ],
    );
    body_says(&part("a", "wod"), &["s.toml:4:22: error: no texture is called `wod`; define it in [textures.NAME]"]);
    // Each doubles the one before.
    let mut wide = "[textures.t0]\ntype = \"checker\"\n".to_owned();
    for i in 1..8 {
        let before = format!("{{ texture = \"t{}\" }}", i - 1);
        wide += &format!("[textures.t{i}]\ntype = \"multiply\"\ncolor1 = {before}\ncolor2 = {before}\n");
    }
    body_says(&wide, &[]);
    wide = wide.replacen("type = \"multiply\"", "type = \"mix\"\nweight = { texture = \"t0\" }", 1);
    body_says(
        &wide,
        &[
            "s.toml:29:11: error: texture `t7` is made of 319 textures; at most 256 are looked up; a texture counts as often \
             as it is used",
        ],
    );
}

#[test]
fn patterns_that_cannot_be() {
    body_says(
        "[textures.a]\ntype = \"noise\"\nrotate = 30\noctaves = 17\nfile = \"a.png\"\n\
         [textures.b]\ntype = \"gradient\"\nfrom = [1, 0]\nstops = [{ at = 0.5, color = 1 }, { at = 0.25, color = 0 }]\n\
         [textures.c]\ntype = \"gradient\"\nfrom = [1, 0]\nto = [1, 0]\nstops = [1]\n\
         [textures.d]\ntype = \"mix\"\ncolor1 = -1\n\
         [textures.e]\ntype = \"plaid\"\nscale = 2\n\
         [textures.f]\ntype = \"gradient\"\nstops = []\n\
         [textures.g]\nscale = [1, 2, 3]\n",
        &[
            "s.toml:4:10: error: `rotate` turns texture coordinates alone; turn the object, or write `coordinates = \"uv\"`",
            "s.toml:5:11: error: `octaves` is out of range: 17 (must be from 1 to 16)",
            "s.toml:6:1: error: `file` is not a key of type `noise`; it belongs to `image`",
            "s.toml:10:9: error: `stops` are not in ascending order (each `at` must be at least that of the stop before)",
            "s.toml:14:1: error: `from` and `to` of a gradient are the same point",
            "s.toml:16:1: error: [textures.NAME] of type `mix` needs `weight`",
            "s.toml:18:10: error: `color1` is out of range: -1 (must be at least 0 and at most 1e30)",
            "s.toml:20:8: error: `type` has no `plaid` (expected one of `image`, `checker`, `grid`, `noise`, `wood`, `marble`, \
             `gradient`, `mix`, `multiply`, `vertex-color`)",
            "s.toml:24:9: error: `stops` has 0 colours (expected from 1 to 64)",
            "s.toml:25:1: error: [textures.NAME] needs `file`",
            "s.toml:26:9: error: `scale` must be an array of 2 numbers, but has 3 items (expected an array of 2 numbers)",
        ],
    );
}
