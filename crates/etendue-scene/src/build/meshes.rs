//! Mesh files: each read once, whatever refers to it.

use super::textures::{TextureFiles, Textures};
use crate::{
    Diagnostic, Diagnostics, Limits, Origin, Severity, SourceMap, crease,
    description::{Located, MeshRecord, MeshSource, SceneDescription, TextureRecord},
    import::Import,
    mesh_file::{self, MeshFile, MeshFormat, MeshLimits, NamedMaterial, Sphere},
    simplify::SimplifyRecord,
};
use etendue::{
    material::Material,
    scene::{Mesh, SceneParts, Shape},
};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

/// What an object is made of, in the scene's parts.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// Of a mesh file, its mesh and its spheres, one of them at least; otherwise one shape.
    pub pieces: Vec<Piece>,
    /// Indices into `SceneParts::materials` of the file's own materials; empty if it has none.
    pub materials: Vec<usize>,
}

/// One shape of an object.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Index into `SceneParts::shapes`.
    pub shape: usize,
    /// The only material that it uses, as index into [`Geometry::materials`]; absent: it uses them all.
    pub material: Option<u32>,
}

impl Geometry {
    /// One shape without materials of its own.
    pub fn of_shape(shape: usize) -> Self {
        Self { pieces: vec![Piece { shape, material: None }], materials: Vec::new() }
    }
}

/// An error if a mesh file is of no kind that is read.
pub fn unknown_ending(path: &Path, origin: &Origin) -> Option<Diagnostic> {
    MeshFormat::of_path(path).is_none().then(|| mesh_file::unknown_kind(path).at(origin.clone()))
}

/// What is done to a mesh when it is loaded.
#[derive(Clone, Copy, PartialEq)]
pub struct Treatment<'a> {
    crease_angle: Option<f64>,
    simplify: Option<&'a SimplifyRecord>,
}

impl<'a> Treatment<'a> {
    pub fn new(crease_angle: Option<f64>, simplify: &'a Option<SimplifyRecord>) -> Self {
        Self { crease_angle, simplify: simplify.as_ref() }
    }

    /// The same comes out of both.
    fn is_like(&self, other: &Self) -> bool {
        let alike =
            |a: &SimplifyRecord, b: &SimplifyRecord| *a == SimplifyRecord { origin: a.origin.clone(), ..b.clone() };
        self.crease_angle == other.crease_angle
            && match (self.simplify, other.simplify) {
                (None, None) => true,
                (Some(a), Some(b)) => alike(a, b),
                _ => false,
            }
    }
}

/// What came of a file; `None`: it could not be read, which has been reported.
type Treated<'a> = (Treatment<'a>, Option<Geometry>);

fn add(shape: Shape, parts: &mut SceneParts) -> usize {
    parts.shapes.push(shape);
    parts.shapes.len() - 1
}

/// Loads meshes and collects findings.
pub struct Loader<'a> {
    pub(super) description: &'a SceneDescription,
    pub(super) sources: &'a mut SourceMap,
    pub(super) limits: &'a Limits,
    names: BTreeMap<&'a str, &'a MeshRecord>,
    inline: BTreeMap<&'a str, Geometry>,
    /// By path, for each treatment that was asked for.
    files: BTreeMap<PathBuf, Vec<Treated<'a>>>,
    /// Mesh files that were read before, by path.
    loaded: BTreeMap<PathBuf, MeshFile>,
    primitives: usize,
    /// The images of textures.
    pub textures: Textures,
    /// What came of each mesh file.
    pub imports: Vec<Import>,
    /// What was found.
    pub findings: Diagnostics,
}

impl<'a> Loader<'a> {
    pub fn new(
        description: &'a SceneDescription,
        sources: &'a mut SourceMap,
        limits: &'a Limits,
        loaded: BTreeMap<PathBuf, MeshFile>,
    ) -> Self {
        Self {
            description,
            sources,
            limits,
            names: description.meshes.iter().map(|m| (m.name.as_str(), m)).collect(),
            inline: BTreeMap::new(),
            files: BTreeMap::new(),
            loaded,
            primitives: 0,
            textures: Textures::default(),
            imports: Vec::new(),
            findings: Diagnostics::new(),
        }
    }

    /// The geometry of `[meshes.NAME]`.
    pub fn named(&mut self, name: &'a Located<String>, parts: &mut SceneParts) -> Option<Geometry> {
        let key = name.value.as_str();
        let Some(MeshRecord { source, crease_angle, simplify, .. }) = self.names.get(key).copied() else {
            let error = Diagnostic::error(format!("no mesh is called `{key}`")).at(name.origin.clone());
            self.findings.push(error);
            return None;
        };
        let treatment = Treatment::new(*crease_angle, simplify);
        let mesh = match source {
            MeshSource::File(path) => return self.file(path, treatment, parts),
            MeshSource::Inline(mesh) => mesh,
        };
        if let Some(known) = self.inline.get(key) {
            return Some(known.clone());
        }
        self.count(mesh.indices.len(), &name.origin)?;
        let mut mesh = mesh.clone();
        self.treat(&mut mesh, treatment)?;
        let geometry = Geometry::of_shape(add(Shape::Mesh(mesh), parts));
        self.inline.insert(key, geometry.clone());
        Some(geometry)
    }

    /// What is in a file.
    pub fn file(
        &mut self,
        path: &Located<PathBuf>,
        treatment: Treatment<'a>,
        parts: &mut SceneParts,
    ) -> Option<Geometry> {
        let key = self.description.folder.join(&path.value);
        let known = self.files.get(&key).and_then(|all| all.iter().find(|(other, _)| other.is_like(&treatment)));
        if let Some((_, known)) = known {
            return known.clone();
        }
        let geometry = self.load(&key, &path.origin, treatment, parts);
        self.files.entry(key).or_default().push((treatment, geometry.clone()));
        geometry
    }

    fn load(&mut self, path: &Path, origin: &Origin, treatment: Treatment, parts: &mut SceneParts) -> Option<Geometry> {
        if let Some(file) = self.loaded.remove(path) {
            return self.add_file(file, path, origin, treatment, parts);
        }
        if let Some(error) = unknown_ending(path, origin) {
            self.findings.push(error);
            return None;
        }
        let limits = MeshLimits { file: self.limits.file_bytes, library: self.limits.library_bytes };
        let file = match mesh_file::open(self.sources, path, &limits) {
            Ok(file) => file,
            Err(error) => {
                self.findings.push(Diagnostic::error(error.to_string()).at(origin.clone()));
                return None;
            }
        };
        match mesh_file::read(self.sources, file, &limits) {
            Ok(file) => self.add_file(file, path, origin, treatment, parts),
            Err(findings) => {
                self.findings.append(findings);
                None
            }
        }
    }

    /// Adds mesh, spheres and materials of a file.
    fn add_file(
        &mut self,
        file: MeshFile,
        path: &Path,
        origin: &Origin,
        treatment: Treatment,
        parts: &mut SceneParts,
    ) -> Option<Geometry> {
        let import = self.imports.len();
        self.imports.push(Import::new(path, &file));
        let MeshFile { mut mesh, spheres, materials, notes, .. } = file;
        self.findings.append(notes);
        self.count(mesh.indices.len().saturating_add(spheres.len()), origin)?;
        if treatment.crease_angle.is_some() && mesh.normals.is_some() {
            let note = Diagnostic::note("`crease_angle` is not used: the file has normals or smoothing groups");
            self.findings.push(note.at(origin.clone()));
        }
        self.treat(&mut mesh, treatment)?;
        if treatment.simplify.is_some() {
            self.imports[import].use_mesh(&mesh);
        }
        let mut pieces = Vec::with_capacity(spheres.len() + 1);
        if !mesh.indices.is_empty() || spheres.is_empty() {
            pieces.push(Piece { shape: add(Shape::Mesh(mesh), parts), material: None });
        }
        pieces.extend(spheres.iter().map(|&Sphere { center, radius, material }| Piece {
            shape: add(Shape::Sphere { center, radius }, parts),
            material: (!materials.is_empty()).then_some(material),
        }));
        let first = parts.materials.len();
        // Names in a library are relative to the library.
        let folder_of = |named: &NamedMaterial| {
            let library = named.origin.as_ref().and_then(Origin::span).map(|span| self.sources.path(span.file));
            library.unwrap_or(path).parent().unwrap_or(Path::new("")).to_owned()
        };
        let folders: Vec<PathBuf> = materials.iter().map(folder_of).collect();
        self.decode_ahead(folders.iter().zip(&materials).map(|(folder, named)| (folder.as_path(), &*named.material)));
        for (named, folder) in materials.iter().zip(folders) {
            self.material(&named.material, named.origin.as_ref(), &folder, Severity::Warning, parts);
        }
        Some(Geometry { pieces, materials: (first..parts.materials.len()).collect() })
    }

    /// Simplifies a mesh and gives it normals, as asked for; `None` after an error.
    fn treat(&mut self, mesh: &mut Mesh, treatment: Treatment) -> Option<()> {
        if let Some(record) = treatment.simplify {
            let (simplified, told) = record.apply(mesh);
            self.findings.push(told);
            *mesh = simplified?;
        }
        if let Some(angle) = treatment.crease_angle {
            crease::smooth(mesh, angle);
        }
        Some(())
    }

    /// Counts triangles and spheres against the limit; `None` after an error.
    fn count(&mut self, primitives: usize, origin: &Origin) -> Option<()> {
        self.primitives = self.primitives.saturating_add(primitives);
        if self.primitives > self.limits.triangles {
            let message = format!("the scene has more than {} triangles", self.limits.triangles);
            self.findings.push(Diagnostic::error(message).at(origin.clone()));
            return None;
        }
        Some(())
    }

    /// Reads the images of materials that are about to be added, several at once; with the folders that names are relative to.
    pub fn decode_ahead<'m>(&mut self, materials: impl Iterator<Item = (&'m Path, &'m Material<TextureRecord>)>) {
        self.textures.read_ahead(materials, self.sources, self.limits);
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
