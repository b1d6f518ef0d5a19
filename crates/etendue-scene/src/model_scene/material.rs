//! Materials that a model can be given by name.

use etendue::bsdf::metals;

/// Names, what they are, and the keys of `[materials.NAME]` that make them.
const MADE: [(&str, &str, &str); 7] = [
    ("clay", "grey and matt", "type = \"diffuse\"\nreflectance = [0.6, 0.585, 0.565]"),
    ("plaster", "white and matt", "type = \"diffuse\"\nreflectance = 0.8"),
    ("plastic", "grey with a gloss", "type = \"mtl\"\ndiffuse = 0.5\nspecular = 0.05\nalpha = 0.1"),
    ("glass", "clear", "type = \"glass\"\nior = 1.5"),
    ("frosted-glass", "clear and rough", "type = \"rough-glass\"\nior = 1.5\nalpha = 0.25"),
    ("mirror", "reflects all light", "type = \"mirror\"\nreflectance = 0.95"),
    ("chrome", "polished chromium", "type = \"rough-metal\"\nmetal = \"chromium\"\nalpha = 0.03"),
];

/// A material by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelMaterial(&'static str);

impl ModelMaterial {
    /// What a model gets that brings no materials.
    pub const DEFAULT: Self = Self("clay");

    /// Every material: some made for this, then the metals.
    pub fn all() -> impl Iterator<Item = Self> {
        MADE.iter().map(|(name, ..)| *name).chain(metals::names()).map(Self)
    }

    /// As on the command line.
    pub fn name(self) -> &'static str {
        self.0
    }

    /// In a few words.
    pub fn words(self) -> String {
        match self.made() {
            Some((_, words, _)) => (*words).to_owned(),
            None => format!("brushed {}", self.0),
        }
    }

    /// The lines of its table.
    pub(super) fn keys(self) -> String {
        match self.made() {
            Some((.., keys)) => (*keys).to_owned(),
            None => format!("type = \"rough-metal\"\nmetal = \"{}\"\nalpha = 0.2", self.0),
        }
    }

    fn made(self) -> Option<&'static (&'static str, &'static str, &'static str)> {
        MADE.iter().find(|(name, ..)| *name == self.0)
    }
}
