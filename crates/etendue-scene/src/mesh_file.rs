//! What a mesh file holds, whatever its format, and reading one by its path.

use crate::{
    Diagnostic, Diagnostics, FileId, Origin, SourceError, SourceMap, Span, description::TextureRecord,
    find_file::find_file, gzip, not_read_yet, obj, off, ply, stl, text::pieces::PIECE_BYTES,
};
use etendue::{
    material::{Material, Scattering},
    scene::Mesh,
    spectrum::Spectrum,
};
use glam::DVec3;
use std::{ops::Range, path::Path, sync::Arc};

/// A mesh file that was read.
#[derive(Clone, Debug)]
pub struct MeshFile {
    /// One mesh with only finite positions and only valid indices. [`Mesh::face_materials`] indexes `materials`; it is
    /// absent if all faces have material 0, or the file names none.
    ///
    /// [`Mesh::origin`] is exactly zero, except on axes where the mesh lies many times its own size away from the file's
    /// origin, so that `f32` keeps its detail there.
    pub mesh: Mesh,
    /// Spheres beside the mesh (OBJ `sphere`).
    pub spheres: Vec<Sphere>,
    /// The materials that faces use, in the order of first use, then those that only spheres use; empty if the file names
    /// none.
    pub materials: Vec<NamedMaterial>,
    /// Named runs of faces, in the order of the file.
    pub groups: Vec<Group>,
    /// How the file counts the vertices of `mesh`.
    pub numbering: Numbering,
    /// What became of the keys and statements of the file and its material libraries.
    pub keys: Vec<KeyUse>,
    /// What was approximated, skipped or ignored: no errors.
    pub notes: Diagnostics,
}

/// What became of a key or statement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyUse {
    /// As in the file; with its option, if that is what it is about. Empty where no one word is.
    pub key: String,
    /// What became of it.
    pub status: KeyStatus,
    /// How often it was there.
    pub count: usize,
    /// The first time.
    pub first: Origin,
}

/// What became of a key or statement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum KeyStatus {
    /// It means here what it says.
    Used,
    /// It counts, but not as it is meant; and how.
    Approximated(String),
    /// It does not count, and why.
    Ignored(String),
}

/// A sphere that a mesh file holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, in the units of the file.
    pub center: DVec3,
    /// Radius, above 0.
    pub radius: f64,
    /// Index into [`MeshFile::materials`]; 0 if that is empty.
    pub material: u32,
}

/// A material that a mesh file names.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedMaterial {
    /// As in the file; empty for faces that name none in a file where others do.
    pub name: String,
    /// What it means here. A name that nothing defines gets [`MeshFile::default_material`].
    pub material: Box<Material<TextureRecord>>,
    /// Where it is defined; if it is not, where it is first used.
    pub origin: Option<Origin>,
}

/// How a file counts the vertices that became a mesh.
///
/// OBJ files count `v` statements, PLY and OFF files their vertices, both with those that no face uses; in STL files, which list
/// corners alone, it is places in the order of their first use by a facet that is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Numbering {
    /// How many there are in the file.
    pub count: usize,
    /// Of each vertex of the mesh, its number in the file, from 0; absent: the same.
    pub of_vertices: Option<Vec<u32>>,
}

impl Numbering {
    /// Every vertex has the number that it has in the file.
    pub fn same(count: usize) -> Self {
        Self { count, of_vertices: None }
    }

    /// Vertex i of the mesh is number `of_vertices[i]` of `count` in the file.
    pub(crate) fn new(count: usize, of_vertices: Vec<u32>) -> Self {
        let same = of_vertices.len() == count && of_vertices.iter().enumerate().all(|(i, &n)| i == n as usize);
        Self { count, of_vertices: (!same).then_some(of_vertices) }
    }

    /// The vertices of the mesh that have these numbers in the file, ascending; several may have one, and what no face uses
    /// has none. Numbers that are not below [`Numbering::count`] are passed over.
    pub fn vertices(&self, numbers: &[u32]) -> Vec<u32> {
        let mut asked = vec![false; self.count];
        for &number in numbers {
            if let Some(asked) = asked.get_mut(number as usize) {
                *asked = true;
            }
        }
        let chosen = |number: u32| asked.get(number as usize).copied().unwrap_or(false);
        match &self.of_vertices {
            None => (0..self.count as u32).filter(|&vertex| chosen(vertex)).collect(),
            Some(of) => (0..of.len() as u32).filter(|&vertex| chosen(of[vertex as usize])).collect(),
        }
    }
}

/// A run of faces with one name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Name of the object (OBJ `o`), if there is one.
    pub object: Option<String>,
    /// Names of the group (OBJ `g`) as written, if there are any.
    pub group: Option<String>,
    /// Its faces (triangles) in [`MeshFile::mesh`].
    pub faces: Range<usize>,
}

/// A material library that was opened.
#[derive(Clone, Debug)]
pub struct Library {
    /// Its place in the source map.
    pub file: FileId,
    /// Its bytes.
    pub bytes: Arc<Vec<u8>>,
    /// What had to be forgiven in its name.
    pub note: Option<String>,
}

/// Finds a material library by the name that a mesh file gives.
pub type OpenLibrary<'a> = &'a mut dyn FnMut(&str) -> Result<Library, SourceError>;

impl MeshFile {
    /// A mesh alone.
    pub fn of_mesh(mesh: Mesh, notes: Diagnostics) -> Self {
        let numbering = Numbering::same(mesh.positions.len());
        Self { mesh, spheres: vec![], materials: vec![], groups: vec![], numbering, keys: vec![], notes }
    }

    /// What faces without a (known) material are made of: grey, half of the light reflected.
    pub fn default_material(name: &str) -> Material<TextureRecord> {
        Material::new(name, Scattering::Diffuse { reflectance: Spectrum::splat(0.5), transmittance: Spectrum::BLACK })
    }
}

/// Formats of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ, with its material libraries.
    Obj,
    /// Stanford PLY.
    Ply,
    /// STL, binary or text.
    Stl,
    /// Geomview's OFF.
    Off,
}

impl MeshFormat {
    /// All formats, with the endings of their files; `.gz` may follow each.
    pub const ALL: [(MeshFormat, &'static str); 4] =
        [(MeshFormat::Obj, "obj"), (MeshFormat::Ply, "ply"), (MeshFormat::Stl, "stl"), (MeshFormat::Off, "off")];

    /// By a path's ending, whatever its case.
    pub fn of_path(path: &Path) -> Option<Self> {
        let ending = |path: &Path| path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let last = ending(path)?;
        let last = if last == "gz" { ending(Path::new(path.file_stem()?))? } else { last };
        Self::ALL.into_iter().find(|(_, name)| *name == last).map(|(format, _)| format)
    }
}

/// Limits of what is read for one mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshLimits {
    /// Most bytes of a file, compressed or not.
    pub file: u64,
    /// Most bytes of a material library.
    pub library: u64,
}

impl Default for MeshLimits {
    fn default() -> Self {
        Self { file: 8 << 30, library: 64 << 20 }
    }
}

/// An OBJ or PLY file of this size or more stays on disk, and is read from there in pieces.
const LARGE: u64 = 16 << 20;

/// Adds a mesh file to a source map, for [`read`]: its bytes, or the open file if it is large and its format can be read in
/// pieces.
///
/// # Errors
/// Whatever keeps it from being read; more than [`MeshLimits::file`] bytes.
pub fn open(sources: &mut SourceMap, path: &Path, limits: &MeshLimits) -> Result<FileId, SourceError> {
    let in_pieces = matches!(MeshFormat::of_path(path), Some(MeshFormat::Obj | MeshFormat::Ply));
    let disk_from = if in_pieces { LARGE } else { u64::MAX };
    sources.open(path, limits.file, disk_from)
}

/// Reads a mesh file that is in the source map, gzipped or not; its format comes from its path. Material libraries are
/// looked for beside it and added to the source map. A gzipped file is added once more, decompressed, since places in
/// messages are places in that.
///
/// # Errors
/// An unknown ending, broken or too large gzip data, and whatever the format's reader finds; see [`crate::obj::read`],
/// [`crate::ply::read`], [`crate::stl::read`] and [`crate::off::read`].
pub fn read(sources: &mut SourceMap, file: FileId, limits: &MeshLimits) -> Result<MeshFile, Diagnostics> {
    let path = sources.path(file).to_owned();
    let Some(format) = MeshFormat::of_path(&path) else {
        let mut found = Diagnostics::new();
        found.push(unknown_kind(&path).at(Span::new(file, 0..0)));
        return Err(found);
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut file = file;
    let content = sources.content(file);
    if !gzip::is_gzip(&content.shown(0..content.len().min(2))) {
        match format {
            MeshFormat::Obj => {
                let open = &mut |name: &str| open_library(sources, folder, name, limits.library);
                return obj::read_content(&content, PIECE_BYTES, file, open);
            }
            MeshFormat::Ply => return ply::read_view(content.view(), file),
            MeshFormat::Stl | MeshFormat::Off => {}
        }
    }
    let mut bytes = sources.bytes(file);
    if gzip::is_gzip(&bytes) {
        let plain = gzip::decompress(&bytes, limits.file).map_err(|error| fatal(&error.to_string(), file))?;
        file = sources.insert(&path, plain).map_err(|error| fatal(&error.to_string(), file))?;
        bytes = sources.bytes(file);
    }
    match format {
        MeshFormat::Ply => ply::read(&bytes, file),
        MeshFormat::Obj => obj::read(bytes, file, &mut |name| open_library(sources, folder, name, limits.library)),
        MeshFormat::Stl => stl::read(&bytes, file),
        MeshFormat::Off => off::read(&bytes, file),
    }
}

/// False if it shows at once that bytes of a mesh file do not say all: they are compressed, or name a material library.
pub(crate) fn may_be_alone(path: &Path, bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(HEAD)];
    let names_library = || head.windows(LIBRARY.len()).any(|word| word == LIBRARY);
    match MeshFormat::of_path(path) {
        _ if gzip::is_gzip(bytes) => false,
        Some(MeshFormat::Obj) => !names_library(),
        Some(MeshFormat::Ply | MeshFormat::Stl | MeshFormat::Off) => true,
        None => false,
    }
}

/// The statement that names a material library in an OBJ file, and in how many bytes it comes if it does, as a rule.
const LIBRARY: &[u8] = b"mtllib";
const HEAD: usize = 16 << 10;

/// Reads bytes of a mesh file that [`may_be_alone`]; `None` where they are broken, or are not alone after all.
pub(crate) fn read_alone(path: &Path, bytes: Arc<Vec<u8>>, file: FileId) -> Option<MeshFile> {
    let mut is_alone = true;
    let open = &mut |name: &str| {
        is_alone = false;
        Err(SourceError::NotFound(name.into()))
    };
    let mesh = match MeshFormat::of_path(path)? {
        MeshFormat::Obj => obj::read(bytes, file, open),
        MeshFormat::Ply => ply::read(&bytes, file),
        MeshFormat::Stl => stl::read(&bytes, file),
        MeshFormat::Off => off::read(&bytes, file),
    };
    mesh.ok().filter(|_| is_alone)
}

/// The error about a file whose ending is of no [`MeshFormat`]: [`Diagnostic::unsupported`] if it is known but not read
/// yet.
pub fn unknown_kind(path: &Path) -> Diagnostic {
    let error = match not_read_yet(path) {
        Some(kind) => Diagnostic::unsupported(format!("{}: {kind} files are not read yet", path.display())),
        None => Diagnostic::error(format!("cannot read {} as a mesh", path.display())),
    };
    let endings = MeshFormat::ALL.map(|(_, ending)| format!(".{ending}")).join(", ");
    error.help(format!("meshes are read from files that end in {endings}, also with .gz"))
}

/// One error about a whole file.
pub(crate) fn fatal(message: &str, file: FileId) -> Diagnostics {
    let mut found = Diagnostics::new();
    found.push(Diagnostic::error(message).at(Span::new(file, 0..0)));
    found
}

/// Opens a material library by the name that a mesh file in `folder` gives; see [`find_file`].
fn open_library(sources: &mut SourceMap, folder: &Path, name: &str, limit: u64) -> Result<Library, SourceError> {
    let (path, note) = find_file(folder, name)?;
    let file = sources.read(&path, limit)?;
    Ok(Library { file, bytes: sources.bytes(file), note })
}
