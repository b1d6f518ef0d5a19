//! What the program tells of itself: schema, completions, manual pages.

mod common;

use common::Folder;

#[test]
fn the_schema_is_json_on_standard_output() {
    let ended = Folder::new().run("--schema").with_code(0);
    let schema: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(schema["$schema"], "http://json-schema.org/draft-07/schema#");
    assert!(schema["definitions"]["materials"]["properties"]["reflectance"].is_object());
    assert_eq!(ended.stderr, "");
    Folder::new().run("--schema render scene.toml").with_code(1).saying(&["help: "]);
}

#[test]
fn every_shell_has_completions() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let ended = folder.run(&format!("completions {shell}")).with_code(0);
        // The last two know nothing of values.
        let values: &[&str] = if ["powershell", "elvish"].contains(&shell) { &[] } else { &["iso", "gold"] };
        for word in ["render", "convert", "transparent"].iter().chain(values) {
            assert!(ended.stdout.contains(word), "{shell}: {word}");
        }
    }
    folder.run("completions").with_code(1).saying(&["<SHELL>"]);
    folder.run("completions tcsh").with_code(1).saying(&["elvish"]);
}

#[test]
fn the_manual_page_has_examples_options_and_every_exit_code() {
    let folder = Folder::new();
    let page = folder.run("man").with_code(0).stdout;
    for part in [".TH etendue 1", "EXAMPLES", "render bunny.obj", "SUBCOMMANDS", "EXIT STATUS", "NO_COLOR"] {
        assert!(page.contains(part), "{part} in {page}");
    }
    for code in ["0", "1", "2", "3", "4", "5", "130"] {
        assert!(page.contains(&format!(".TP\n{code}\n")), "{code}");
    }
    let page = folder.run("man render").with_code(0).stdout;
    assert!(page.contains(".TH etendue\\-render 1") || page.contains(".TH etendue-render 1"), "{page}");
    assert!(page.contains("\\-\\-transparent") && page.contains("WITHOUT A SCENE FILE"), "{page}");
    folder.run("man paint").with_code(1).saying(&["no subcommand `paint`", "help: there are render"]);
}
