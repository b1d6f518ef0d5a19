//! Help leads with examples, and messages come with hints.

mod common;

use common::{Folder, SCENE};

const SUBCOMMANDS: [&str; 7] = ["render", "scene", "info", "convert", "diff", "completions", "man"];

#[test]
fn help_leads_with_examples() {
    let folder = Folder::new();
    for words in std::iter::once("--help".to_owned()).chain(SUBCOMMANDS.map(|name| format!("{name} --help"))) {
        let help = folder.run(&words).with_code(0).stdout;
        let mut lines = help.lines();
        assert_eq!(lines.next(), Some("Examples:"), "{words}");
        assert!(lines.next().unwrap().starts_with("  etendue "), "{words}");
        assert!(help.contains("Usage: etendue"), "{words}");
        assert!(help.lines().all(|line| line.chars().count() <= 140), "{words}");
    }
    let help = folder.run("--help").stdout;
    assert!(SUBCOMMANDS.iter().all(|name| help.contains(&format!("\n  {name} "))), "{help}");
}

#[test]
fn examples_in_help_parse() {
    let folder = Folder::new();
    for words in std::iter::once("--help".to_owned()).chain(SUBCOMMANDS.map(|name| format!("{name} --help"))) {
        let help = folder.run(&words).stdout;
        let examples = help
            .lines()
            .take_while(|line| !line.starts_with("Usage"))
            .filter_map(|line| line.strip_prefix("  etendue "));
        for example in examples {
            // What follows two blanks is a comment, what follows a bar or an arrow is for the shell.
            let words = example.split("  ").next().unwrap();
            let words = words.split(" | ").next().unwrap().split(" > ").next().unwrap();
            let ended = folder.run(words);
            assert!(![1, 101].contains(&ended.code), "{words}: {ended:#?}");
        }
    }
}

#[test]
fn messages_have_hints() {
    let folder = Folder::new();
    folder.put("words.txt", "words");
    folder.put("scene.toml", SCENE);
    folder.put("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (words, code) in [
        ("render none.toml", 2),
        ("render words.txt", 3),
        ("render scene.toml --view front", 1),
        ("scene words.txt", 2),
        ("scene a.obj -o a.png", 1),
        ("info words.txt", 2),
        ("info a.glb", 3),
        ("convert scene.toml a.png", 1),
        ("convert a.obj a.png", 1),
        ("convert a.obj a.off", 1),
        ("man paint", 1),
    ] {
        folder.run(words).with_code(code).saying(&["help: "]);
    }
}

#[test]
fn no_colours_where_they_are_not_wanted() {
    let folder = Folder::new();
    let output = folder.command("render none.toml").env("NO_COLOR", "1").env("CLICOLOR_FORCE", "1").output().unwrap();
    assert!(!output.stderr.contains(&0x1b), "{output:?}");
}
