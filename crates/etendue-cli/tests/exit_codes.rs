//! Each kind of failure has its exit code and names what is wrong.

mod common;

use common::{Folder, SCENE};
use std::fs;

#[test]
fn usage_errors_exit_1_and_tell_the_range() {
    let folder = Folder::new();
    let cases = [
        ("", "Usage"),
        ("paint scene.toml", "unrecognized subcommand"),
        ("render", "<INPUT>"),
        ("render scene.toml --spp 0", "1..=16777216"),
        ("render scene.toml --spp 1e3", "--spp"),
        ("render scene.toml --threads 0", "1..=1024"),
        ("render scene.toml --tile 0", "1..=4096"),
        ("render scene.toml --wave 65537", "1..=65536"),
        ("render scene.toml --depth 0", "1.."),
        ("render scene.toml --seed -1", "--seed"),
        ("render scene.toml --size 0x5", "from 1 to"),
        ("render scene.toml --crop 4,4,2,8", "X0 < X1"),
        ("render scene.toml --crop 0,0,17,12", "16 x 12"),
        ("render scene.toml --size 1000000x1000000", "too large"),
        ("render scene.toml --exposure nan", "from -64 to 64"),
        ("render scene.toml --sampler halton", "sobol"),
        ("render scene.toml --integrator x", "light-split"),
        ("render scene.toml --accel x", "kdtree"),
        ("render scene.toml --filter x", "gaussian"),
        ("render scene.toml --tonemap x", "none"),
        ("render scene.toml --aov albedo,x", "variance"),
        ("render scene.toml --isa x", "portable"),
        ("render scene.toml -o a.jpg", ".png, .exr, .hdr, .pfm"),
        ("render scene.toml -o a", ".png, .exr, .hdr, .pfm"),
        ("diff a.exr", "<B>"),
        ("diff a.exr b.exr --metric psnr", "relmse"),
        ("diff a.exr b.exr --fail-above -1", "expected a number"),
        ("diff a.exr b.exr -o heat.exr", ".png"),
    ];
    for (words, part) in cases {
        let ended = folder.run(words).with_code(1).saying(&[part]);
        assert_eq!(ended.stdout, "", "{words}");
    }
    assert!(folder.files().is_empty(), "nothing is written: {:?}", folder.files());
}

#[test]
fn help_and_version_exit_0_on_standard_output() {
    let folder = Folder::new();
    for words in ["--help", "--version", "help render", "render --help", "diff -h"] {
        let ended = folder.run(words).with_code(0);
        assert!(ended.stdout.contains("etendue") && ended.stderr.is_empty(), "{ended:#?}");
    }
}

#[test]
fn bad_scenes_exit_2_with_every_finding_in_its_place() {
    let folder = Folder::new();
    let scene =
        SCENE.replace("look_at", "lok_at").replace("fov = 40", "fov = nan").replace("\"white\"\n", "\"whit\"\n");
    folder.put("bad.toml", &scene);
    let line = |needle: &str| scene.lines().position(|l| l.starts_with(needle)).unwrap() + 1;
    let ended = folder.run("render bad.toml").with_code(2).saying(&[
        &format!("bad.toml:{}:1", line("lok_at")),
        "did you mean `look_at`?",
        &format!("bad.toml:{}:7", line("fov = nan")),
        &format!("bad.toml:{}:12", line("material = \"whit\"")),
        "^^^",
        "lok_at = [0, 0, 0]",
    ]);
    assert!(ended.stdout.is_empty() && !ended.stderr.contains('\u{1b}'), "{ended:#?}");
    assert_eq!(folder.files(), ["bad.toml"]);
}

#[test]
fn missing_and_unreadable_inputs_exit_2() {
    let folder = Folder::new();
    folder.run("render none.toml").with_code(2).saying(&["none.toml"]);
    fs::create_dir(folder.path("folder.toml")).unwrap();
    folder.run("render folder.toml").with_code(2).saying(&["folder.toml"]);
    folder.put("bytes.toml", [0xff, 0xfe, 0, b'[', 0x80]);
    folder.run("render bytes.toml").with_code(2).saying(&["bytes.toml"]);
    folder.put("mesh.toml", format!("{SCENE}\n[[objects]]\nfile = \"gone.obj\"\nmaterial = \"white\"\n"));
    folder.run("render mesh.toml").with_code(2).saying(&["gone.obj", "mesh.toml:"]);
    folder.run("diff none.exr scene.toml").with_code(2).saying(&["none.exr"]);
    folder.run("diff scene.toml scene.toml").with_code(2).saying(&["scene.toml", "no PNG, JPEG, HDR, OpenEXR"]);
}

#[test]
fn inputs_of_other_kinds_exit_3() {
    let folder = Folder::new();
    folder.put("scene.xml", "<scene/>");
    folder.run("render scene.xml").with_code(3).saying(&["scene.xml", "Mitsuba files are not read yet", ".toml"]);
    folder.put("mesh.toml", "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n[[objects]]\nfile = \"a.glb\"\n");
    folder.run("render mesh.toml").with_code(3).saying(&["mesh.toml:5:8", "a.glb: glTF files are not read yet"]);
    folder.put("both.toml", "[camera]\nposition = [0, 0, 5]\nlook_at = 1\n[[objects]]\nfile = \"a.glb\"\n");
    folder.run("render both.toml").with_code(2);
}

#[test]
fn instruction_sets_that_the_processor_lacks_exit_3() {
    let folder = Folder::new();
    for isa in etendue_accel::Isa::ALL {
        let code = if etendue_accel::Isa::available().contains(&isa) { 0 } else { 3 };
        folder.run(&format!("render scene.toml -o a.png --isa {isa}")).with_code(code);
    }
}

#[test]
fn unwritable_outputs_exit_4_before_rendering() {
    let folder = Folder::new();
    // So many samples that the test would not end if it rendered first.
    let render = |output: &str| folder.run(&format!("render scene.toml --spp 16777216 -o {output}")).with_code(4);
    render("no/such/a.png").saying(&["no/such/a.png", "does not exist"]);
    fs::create_dir(folder.path("folder.png")).unwrap();
    render("folder.png").saying(&["folder.png", "a folder"]);
    render("good.exr -o no/a.exr").saying(&["no/a.exr"]);
    folder.put("old.png", "kept");
    let mut permissions = fs::metadata(folder.path("old.png")).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(folder.path("old.png"), permissions).unwrap();
    render("old.png").saying(&["old.png", "read-only"]);
    assert_eq!(fs::read(folder.path("old.png")).unwrap(), b"kept");
    assert_eq!(folder.files(), ["folder.png", "old.png"]);
}

#[cfg(target_os = "linux")]
#[test]
fn standard_output_may_close_early_but_must_not_be_full() {
    use std::process::Stdio;
    let folder = Folder::new();
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let child = folder.command("render scene.toml --json").stdout(writer).stderr(Stdio::piped()).spawn().unwrap();
    let closed = common::Ended::from(child.wait_with_output().unwrap(), "closed pipe");
    closed.with_code(0);
    assert_eq!(folder.files(), ["scene.exr", "scene.png"]);
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = folder.command("render scene.toml --json").stdout(full).output().unwrap();
    common::Ended::from(output, "full").with_code(4).saying(&["standard output"]);
}
