//! `cargo xtask gallery`.
mod inputs;
pub fn run(names: &[&str]) -> bool {
    let dir = crate::root().join("gallery/inputs");
    std::fs::create_dir_all(&dir).unwrap();
    for i in inputs::INPUTS.iter().filter(|i| names.is_empty() || names.contains(&i.name)) {
        std::fs::write(dir.join(i.name), (i.make)()).unwrap();
    }
    true
}
