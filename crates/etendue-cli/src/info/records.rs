//! Parts that what is told of scenes and of models shares. The names of their fields are the keys of the JSON, which the manual
//! tells and which stay.

use super::text::{self, Page};
use etendue::{material::Material, texture::Transfer};
use etendue_scene::{
    Diagnostics, Origin, Severity, SourceMap,
    import::{LoadedTexture, counted, type_name},
    mesh_file::{KeyStatus, KeyUse},
};
use serde::Serialize;

/// Lowest and highest corner.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Bounds {
    pub min: [f64; 3],
    pub max: [f64; 3],
}

impl Bounds {
    /// Of points; `None` if there are none.
    pub fn of(points: impl IntoIterator<Item = [f64; 3]>) -> Option<Self> {
        points.into_iter().fold(None, |bounds: Option<Self>, p| {
            let Self { mut min, mut max } = bounds.unwrap_or(Self { min: p, max: p });
            for axis in 0..3 {
                min[axis] = min[axis].min(p[axis]);
                max[axis] = max[axis].max(p[axis]);
            }
            Some(Self { min, max })
        })
    }

    /// The eight corners.
    pub fn corners(&self) -> [[f64; 3]; 8] {
        let ends = [self.min, self.max];
        std::array::from_fn(|i| [ends[i & 1][0], ends[i >> 1 & 1][1], ends[i >> 2 & 1][2]])
    }

    /// For people.
    pub fn text(&self) -> String {
        let [x, y, z] = std::array::from_fn(|axis| text::number(self.max[axis] - self.min[axis]));
        format!("{} to {}, size {x} x {y} x {z}", text::point(self.min), text::point(self.max))
    }
}

/// A material.
#[derive(Debug, Serialize)]
pub struct MaterialEntry {
    pub name: String,
    /// As in `[materials.NAME]`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    pub emits: bool,
    pub opaque: bool,
}

impl MaterialEntry {
    pub fn new(material: &Material) -> Self {
        Self {
            name: material.name.clone(),
            kind: type_name(&material.scattering),
            emits: material.emission.is_some(),
            opaque: material.is_opaque(),
        }
    }

    pub fn text(&self) -> String {
        let name = if self.name.is_empty() { "(no name)" } else { &self.name };
        let emits = if self.emits { ", emits" } else { "" };
        let opaque = if self.opaque { "" } else { ", partly transparent" };
        format!("{name}: {}{emits}{opaque}", self.kind)
    }
}

/// An image on surfaces.
#[derive(Debug, Serialize)]
pub struct TextureEntry {
    pub file: String,
    pub width: u32,
    pub height: u32,
    pub channels: usize,
    pub alpha: bool,
    /// `srgb` or `linear`.
    pub encoding: &'static str,
    /// In memory.
    pub bytes: usize,
}

impl TextureEntry {
    pub fn new(texture: &LoadedTexture) -> Self {
        let LoadedTexture { path, image } = texture;
        let [width, height] = image.size();
        Self {
            file: path.display().to_string(),
            width,
            height,
            channels: image.channels(),
            alpha: image.has_alpha(),
            encoding: match image.transfer() {
                Transfer::Srgb => "srgb",
                Transfer::Linear => "linear",
            },
            bytes: image.bytes(),
        }
    }

    pub fn text(&self) -> String {
        let Self { file, width, height, channels, encoding, bytes, .. } = self;
        let size = text::bytes(*bytes as u64);
        format!("{file}: {width} x {height}, {}, {encoding}, {size}", counted(*channels, "channel"))
    }
}

/// What became of a key or statement of an imported file.
#[derive(Debug, Serialize)]
pub struct KeyEntry {
    pub key: String,
    /// `used`, `approximated` or `ignored`.
    pub status: &'static str,
    /// How it is approximated, or why it is ignored.
    pub why: Option<String>,
    pub count: usize,
    /// Where it is first.
    pub file: String,
    pub line: usize,
}

impl KeyEntry {
    pub fn new(key: &KeyUse, sources: &SourceMap) -> Self {
        let (status, why) = match &key.status {
            KeyStatus::Used => ("used", None),
            KeyStatus::Approximated(how) => ("approximated", Some(how.clone())),
            KeyStatus::Ignored(why) => ("ignored", Some(why.clone())),
        };
        let (file, line) = place(Some(&key.first), sources).unwrap_or_default();
        Self { key: key.key.clone(), status, why, count: key.count, file, line }
    }

    fn text(&self) -> String {
        let Self { key, why, count, file, line, .. } = self;
        let key = if key.is_empty() { "" } else { &format!("{key}, ") };
        let times = if *count == 1 { String::new() } else { format!("{count} times, first in ") };
        let why = why.as_deref().map(|why| format!(": {why}")).unwrap_or_default();
        format!("{key}{times}{file}:{line}{why}")
    }

    /// Rows of a page: those used in one, the others each in its own.
    pub fn rows(keys: &[Self], page: &mut Page) {
        let with = |status| keys.iter().filter(move |key| key.status == status);
        let used: Vec<&str> = with("used").map(|key| &key.key[..]).collect();
        if !used.is_empty() {
            page.row("keys used", used.join(" "));
        }
        page.rows("approximated", with("approximated").map(Self::text));
        page.rows("ignored", with("ignored").map(Self::text));
    }
}

/// What was found while reading.
#[derive(Debug, Serialize)]
pub struct FindingEntry {
    /// `warning` or `note`.
    pub severity: String,
    pub message: String,
    /// Absent if it is of no one place.
    pub file: Option<String>,
    pub line: Option<usize>,
}

impl FindingEntry {
    /// Those kept of a collection.
    pub fn all(found: &Diagnostics, sources: &SourceMap) -> Vec<Self> {
        let entry = |d: &etendue_scene::Diagnostic| {
            let (file, line) = place(d.origin.as_ref(), sources).unzip();
            Self { severity: d.severity.to_string(), message: d.message.clone(), file, line }
        };
        found.iter().map(entry).collect()
    }

    /// Rows of a page, of what `keys` do not say already.
    pub fn rows(found: &[Self], keys: &[&KeyEntry], page: &mut Page) {
        let said = |entry: &Self| keys.iter().any(|key| key.why.as_ref() == Some(&entry.message));
        for severity in [Severity::Warning, Severity::Note] {
            let name = severity.to_string();
            let of_it = found.iter().filter(|entry| entry.severity == name && !said(entry));
            let line = |entry: &Self| match (&entry.file, entry.line) {
                (Some(file), Some(line)) => format!("{file}:{line}: {}", entry.message),
                _ => entry.message.clone(),
            };
            page.rows(&format!("{name}s"), of_it.map(line));
        }
    }
}

fn place(origin: Option<&Origin>, sources: &SourceMap) -> Option<(String, usize)> {
    let span = origin?.span()?;
    Some((sources.path(span.file).display().to_string(), sources.position(span).line))
}

/// Bytes in memory, without what is made to trace rays.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Memory {
    pub geometry: usize,
    pub textures: usize,
}

impl Memory {
    pub fn text(&self) -> String {
        let [geometry, textures] = [self.geometry, self.textures].map(|n| text::bytes(n as u64));
        format!("geometry {geometry}, textures {textures}")
    }
}

/// Bytes of the arrays of a mesh.
pub fn mesh_bytes(mesh: &etendue::scene::Mesh) -> usize {
    let per_vertex = 12
        + mesh.normals.as_ref().map_or(0, |_| 12)
        + mesh.uvs.as_ref().map_or(0, |_| 8)
        + mesh.colors.as_ref().map_or(0, |_| 16);
    let per_face = 12 + mesh.face_materials.as_ref().map_or(0, |_| 4);
    mesh.positions.len() * per_vertex + mesh.indices.len() * per_face
}

/// The points of a mesh.
pub fn points(mesh: &etendue::scene::Mesh) -> impl Iterator<Item = [f64; 3]> + '_ {
    let origin = mesh.origin.to_array();
    mesh.positions.iter().map(move |p| std::array::from_fn(|axis| origin[axis] + f64::from(p[axis])))
}
