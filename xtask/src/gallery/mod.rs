//! `cargo xtask gallery`.
mod inputs;
pub fn run(_: &[&str]) -> bool {
    let dir = crate::root().join("gallery/inputs");
    std::fs::create_dir_all(&dir).unwrap();
    for i in inputs::INPUTS {
        std::fs::write(dir.join(i.name), (i.make)()).unwrap();
    }
    true
}
