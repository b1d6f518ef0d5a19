//! What is told of a model.

use super::{
    Told,
    records::{Bounds, FindingEntry, KeyEntry, MaterialEntry, Memory, TextureEntry, mesh_bytes, points},
    text::{self, Page},
};
use crate::{
    exit::{Exit, Failure},
    model, report,
};
use etendue_scene::{
    Limits, SourceMap, build_with,
    import::counted,
    mesh_file::{MeshFile, MeshFormat},
    model_scene, read_toml,
};
use serde::Serialize;
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

/// Names of objects and groups that are told.
const NAMES: usize = 1000;

/// A model.
#[derive(Debug, Serialize)]
pub struct MeshInfo {
    kind: &'static str,
    file: String,
    format: &'static str,
    /// Of the file.
    file_bytes: u64,
    vertices: usize,
    triangles: usize,
    spheres: usize,
    normals: bool,
    uvs: bool,
    vertex_colors: bool,
    /// Names of objects, and of groups, each once, at most a thousand.
    objects: Vec<String>,
    groups: Vec<String>,
    materials: Vec<MaterialEntry>,
    textures: Vec<TextureEntry>,
    /// Absent without vertices and spheres; in the units of the file.
    bounds: Option<Bounds>,
    memory: Memory,
    keys: Vec<KeyEntry>,
    findings: Vec<FindingEntry>,
}

/// Reads a model and the images of its materials, as a scene would.
pub fn read(path: &Path) -> Result<MeshInfo, Failure> {
    let limits = Limits::default();
    let mut sources = SourceMap::new();
    let mesh = model::read(path, &mut sources, &limits)?;
    let scene = model_scene::bare(path).map_err(|e| Failure::new(Exit::BadInput, e))?.into_bytes();
    let file = sources.insert("scene", scene.clone())?;
    let (description, found) = read_toml(file, &scene, Path::new(""));
    let built = match &description {
        Some(description) => {
            build_with(description, &mut sources, &limits, BTreeMap::from([(path.to_owned(), mesh.clone())]))
        }
        None => Err(found),
    };
    let input = built.map_err(|found| {
        report::diagnostics(&found, &sources);
        Failure::reported(Exit::of(&found))
    })?;
    let textures: Vec<_> = input.textures.iter().map(TextureEntry::new).collect();
    // Grey is added to faces of files without materials.
    let own = if mesh.materials.is_empty() { &[] } else { &input.parts.materials[..] };
    Ok(MeshInfo {
        kind: "mesh",
        file: path.display().to_string(),
        format: MeshFormat::of_path(path)
            .and_then(|format| MeshFormat::ALL.into_iter().find(|(f, _)| *f == format))
            .map_or("", |(_, name)| name),
        file_bytes: std::fs::metadata(path).map_or(0, |m| m.len()),
        vertices: mesh.mesh.positions.len(),
        triangles: mesh.mesh.indices.len(),
        spheres: mesh.spheres.len(),
        normals: mesh.mesh.normals.is_some(),
        uvs: mesh.mesh.uvs.is_some(),
        vertex_colors: mesh.mesh.colors.is_some(),
        objects: distinct(mesh.groups.iter().map(|g| &g.object)),
        groups: distinct(mesh.groups.iter().map(|g| &g.group)),
        materials: own.iter().map(MaterialEntry::new).collect(),
        bounds: bounds(&mesh),
        memory: Memory {
            geometry: mesh_bytes(&mesh.mesh) + mesh.spheres.len() * size_of::<etendue_scene::mesh_file::Sphere>(),
            textures: textures.iter().map(|t| t.bytes).sum(),
        },
        textures,
        keys: mesh.keys.iter().map(|key| KeyEntry::new(key, &sources)).collect(),
        findings: FindingEntry::all(&input.findings, &sources),
    })
}

fn distinct<'a>(names: impl Iterator<Item = &'a Option<String>>) -> Vec<String> {
    let mut seen = BTreeSet::new();
    names.flatten().filter(|name| seen.insert(*name)).take(NAMES).cloned().collect()
}

fn bounds(mesh: &MeshFile) -> Option<Bounds> {
    let spheres = mesh.spheres.iter().flat_map(|s| {
        [-s.radius, s.radius].map(|r| {
            let [x, y, z] = s.center.to_array();
            [x + r, y + r, z + r]
        })
    });
    Bounds::of(points(&mesh.mesh).chain(spheres))
}

impl Told for MeshInfo {
    fn text(&self) -> String {
        let mut page = Page::new(format!("{}: {} model, {}", self.file, self.format, text::bytes(self.file_bytes)));
        page.row("vertices", text::count(self.vertices));
        page.row("triangles", text::count(self.triangles));
        if self.spheres > 0 {
            page.row("spheres", text::count(self.spheres));
        }
        let has = |there| if there { "yes" } else { "no" };
        page.row("normals", has(self.normals));
        page.row("texture uvs", has(self.uvs));
        if self.vertex_colors {
            page.row("vertex colours", "yes");
        }
        for (name, names) in [("objects", &self.objects), ("groups", &self.groups)] {
            if !names.is_empty() {
                page.row(name, listed(names));
            }
        }
        page.rows("materials", self.materials.iter().map(MaterialEntry::text));
        page.rows("textures", self.textures.iter().map(TextureEntry::text));
        page.rows("bounds", self.bounds.iter().map(|b| format!("{}, in the file's units", b.text())));
        page.row("memory", self.memory.text());
        KeyEntry::rows(&self.keys, &mut page);
        FindingEntry::rows(&self.findings, &self.keys.iter().collect::<Vec<_>>(), &mut page);
        page.text()
    }
}

/// How many, and the first few.
fn listed(names: &[String]) -> String {
    const SHOWN: usize = 8;
    let some: Vec<&str> = names.iter().take(SHOWN).map(String::as_str).collect();
    let more = if names.len() > SHOWN { ", ..." } else { "" };
    format!("{}: {}{more}", counted(names.len(), "name"), some.join(", "))
}
