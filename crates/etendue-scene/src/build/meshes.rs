//! Mesh files: each read once, whatever refers to it.

use super::textures::{TextureFiles, Textures};
use crate::{
    Diagnostic, Diagnostics, Limits, Origin, Severity, SourceMap,
    description::{Located, MeshSource, SceneDescription, TextureRecord},
    mesh_file::{self, MeshFile, MeshFormat, MeshLimits},
};
use etendue::{
    material::Material,
    scene::{Mesh, SceneParts, Shape},
};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

/// A mesh in the scene's parts.
#[derive(Clone, Debug)]
pub struct MeshRef {
    /// Index into `SceneParts::shapes`.
    pub shape: usize,
    /// Indices into `SceneParts::materials` of the file's own materials; empty if it has none.
    pub materials: Vec<usize>,
}

/// An error if a mesh file is of no kind that is read.
pub fn unknown_ending(path: &Path, origin: &Origin) -> Option<Diagnostic> {
    let error = || {
        let endings = MeshFormat::ALL.map(|(_, ending)| format!(".{ending}")).join(", ");
        Diagnostic::error(format!("cannot read {} as a mesh", path.display()))
            .at(origin.clone())
            .help(format!("meshes are read from files that end in {endings}, also with .gz"))
    };
    MeshFormat::of_path(path).is_none().then(error)
}

/// Loads meshes and collects findings.
pub struct Loader<'a> {
    description: &'a SceneDescription,
    sources: &'a mut SourceMap,
    limits: &'a Limits,
    names: BTreeMap<&'a str, &'a MeshSource>,
    inline: BTreeMap<&'a str, MeshRef>,
    /// `None`: could not be read, which has been reported.
    files: BTreeMap<PathBuf, Option<MeshRef>>,
    triangles: usize,
    textures: Textures,
    /// What was found.
    pub findings: Diagnostics,
}

impl<'a> Loader<'a> {
    pub fn new(description: &'a SceneDescription, sources: &'a mut SourceMap, limits: &'a Limits) -> Self {
        Self {
            description,
            sources,
            limits,
            names: description.meshes.iter().map(|m| (m.name.as_str(), &m.source)).collect(),
            inline: BTreeMap::new(),
            files: BTreeMap::new(),
            triangles: 0,
            textures: Textures::default(),
            findings: Diagnostics::new(),
        }
    }

    /// The mesh of `[meshes.NAME]`.
    pub fn named(&mut self, name: &'a Located<String>, parts: &mut SceneParts) -> Option<MeshRef> {
        let key = name.value.as_str();
        match self.names.get(key).copied() {
            None => {
                let error = Diagnostic::error(format!("no mesh is called `{key}`")).at(name.origin.clone());
                self.findings.push(error);
                None
            }
            Some(MeshSource::File(path)) => self.file(path, parts),
            Some(MeshSource::Inline(mesh)) => {
                if let Some(known) = self.inline.get(key) {
                    return Some(known.clone());
                }
                let shape = self.add(mesh.clone(), &name.origin, parts)?;
                let mesh = MeshRef { shape, materials: Vec::new() };
                self.inline.insert(key, mesh.clone());
                Some(mesh)
            }
        }
    }

    /// The mesh of a file.
    pub fn file(&mut self, path: &Located<PathBuf>, parts: &mut SceneParts) -> Option<MeshRef> {
        let full = self.description.folder.join(&path.value);
        if let Some(known) = self.files.get(&full) {
            return known.clone();
        }
        let mesh = self.load(&full, &path.origin, parts);
        self.files.insert(full, mesh.clone());
        mesh
    }

    fn load(&mut self, path: &Path, origin: &Origin, parts: &mut SceneParts) -> Option<MeshRef> {
        if let Some(error) = unknown_ending(path, origin) {
            self.findings.push(error);
            return None;
        }
        let limits = MeshLimits { file: self.limits.file_bytes, library: self.limits.library_bytes };
        let file = match self.sources.read(path, limits.file) {
            Ok(file) => file,
            Err(error) => {
                self.findings.push(Diagnostic::error(error.to_string()).at(origin.clone()));
                return None;
            }
        };
        match mesh_file::read(self.sources, file, &limits) {
            Ok(MeshFile { mesh, materials, notes, .. }) => {
                self.findings.append(notes);
                let shape = self.add(mesh, origin, parts)?;
                let first = parts.materials.len();
                for named in materials {
                    // Names in a library are relative to the library.
                    let library = named.origin.as_ref().and_then(Origin::span).map(|span| self.sources.path(span.file));
                    let folder = library.unwrap_or(path).parent().unwrap_or(Path::new("")).to_owned();
                    self.material(&named.material, named.origin.as_ref(), &folder, Severity::Warning, parts);
                }
                Some(MeshRef { shape, materials: (first..parts.materials.len()).collect() })
            }
            Err(findings) => {
                self.findings.append(findings);
                None
            }
        }
    }

    /// Adds a mesh to the parts, under the limit of triangles.
    fn add(&mut self, mesh: Mesh, origin: &Origin, parts: &mut SceneParts) -> Option<usize> {
        self.triangles = self.triangles.saturating_add(mesh.indices.len());
        if self.triangles > self.limits.triangles {
            let message = format!("the scene has more than {} triangles", self.limits.triangles);
            self.findings.push(Diagnostic::error(message).at(origin.clone()));
            return None;
        }
        parts.shapes.push(Shape::Mesh(mesh));
        Some(parts.shapes.len() - 1)
    }

    /// Adds a material: its textures loaded, whose names are relative to `folder`. Reports what the renderer would refuse,
    /// and with severity `missing` images that cannot be read.
    pub fn material(
        &mut self,
        material: &Material<TextureRecord>,
        origin: Option<&Origin>,
        folder: &Path,
        missing: Severity,
        parts: &mut SceneParts,
    ) {
        if let Err(error) = material.validate() {
            let error = Diagnostic::error(error.to_string());
            self.findings.push(match origin {
                Some(origin) => error.at(origin.clone()),
                None => error,
            });
        }
        let mut files =
            TextureFiles { folder, missing, sources: self.sources, limits: self.limits, findings: &mut self.findings };
        parts
            .materials
            .push(material.map_textures(&mut |record, transfer| self.textures.load(record, transfer, &mut files)));
    }
}
