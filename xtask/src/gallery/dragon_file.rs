//! Another dragon in place of the project's own, placed by the same rules.

use super::{inputs, program::Program};
use crate::disk::{read, write};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The file in the scenes.
const OWN: &str = "inputs/dragon.ply.gz";

/// A dragon's file and the steps of transformation that stand for the first one of the scenes.
pub struct Placed {
    file: PathBuf,
    steps: String,
}

impl Placed {
    /// Asks the program for the file's size. The dragon is y up with its head towards -x; the scenes want z up, the head towards
    /// -y, and a length of 3.
    pub fn new(file: &Path, program: &Program) -> Result<Self, String> {
        let file = file.canonicalize().map_err(|e| format!("{}: {e}", file.display()))?;
        let info = program.info(&file)?;
        let bound = |side: &str| info["bounds"][side][0].as_f64();
        match (bound("min"), bound("max")) {
            (Some(low), Some(high)) if high > low => Ok(Self { steps: steps(3.0 / (high - low)), file }),
            _ => Err(format!("{}: no mesh that has a length", file.display())),
        }
    }

    /// A scene with this dragon in `folder`, or the scene itself if it has none. `folder` lies beside the inputs.
    pub fn scene(&self, scene: &Path, folder: &Path) -> Result<PathBuf, String> {
        let text = String::from_utf8(read(scene)?).map_err(|e| format!("{}: {e}", scene.display()))?;
        let Some(text) = self.put_into(&text) else { return Ok(scene.to_owned()) };
        let path = folder.join(scene.file_name().unwrap_or_default());
        write(&path, text.as_bytes())?;
        Ok(path)
    }

    fn put_into(&self, text: &str) -> Option<String> {
        let own_scale = format!("{{ scale = {} }}", inputs::DRAGON_SCALE);
        if !text.contains(OWN) || !text.contains(&own_scale) {
            return None;
        }
        // A string of JSON is one of TOML.
        let file = Value::from(self.file.to_string_lossy()).to_string();
        let text = text.replace(&format!("\"{OWN}\""), &file).replace("\"inputs/", "\"../inputs/");
        Some(text.replace(&own_scale, &self.steps))
    }
}

fn steps(scale: f64) -> String {
    format!(
        "{{ rotate = {{ axis = \"x\", angle = 90 }} }}, {{ rotate = {{ axis = \"z\", angle = 90 }} }}, {{ scale = {scale:e} }}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::root;
    use std::fs;

    #[test]
    fn every_scene_with_the_dragon_takes_another() {
        let placed = Placed { file: PathBuf::from("/else/where.ply"), steps: steps(0.5) };
        let mut with_dragon = Vec::new();
        for scene in super::super::scenes(&root().join("gallery")).unwrap() {
            let text = fs::read_to_string(&scene).unwrap();
            match placed.put_into(&text) {
                Some(other) => {
                    assert!(
                        other.contains("\"/else/where.ply\"") && other.contains("scale = 5e-1") && !other.contains(OWN)
                    );
                    assert!(!other.contains("\"inputs/"));
                    with_dragon.push(scene.file_stem().unwrap().to_string_lossy().into_owned());
                }
                None => assert!(!text.contains("dragon"), "{}", scene.display()),
            }
        }
        assert_eq!(with_dragon[..], ["figure-1", "figure-11", "figure-2", "figure-7"]);
    }
}
