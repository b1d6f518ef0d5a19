//! The materials of a script's scene: those of its mesh files that the old program understood in its own way.

use super::search::Search;
use crate::{
    Diagnostic, Diagnostics, FileId, Origin, SourceMap,
    description::TextureRecord,
    find_file::find_file,
    mesh_file::{MeshFile, MeshFormat},
    mtl::{self, OldMaterial, OldUse},
};
use etendue::{material::Material, spectrum::Spectrum};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

/// What a script's scene states of materials.
#[derive(Debug, Default)]
pub struct Materials {
    /// Materials, each name once.
    pub surfaces: Vec<Surface>,
    /// Images, each name once; taken as they are stored.
    pub images: Vec<Image>,
    /// What fills the world.
    pub medium: Option<Medium>,
    libraries: BTreeMap<FileId, Vec<OldMaterial>>,
    /// Index of the surface that stands for a material.
    stated: BTreeMap<Origin, usize>,
}

/// A material of the scene.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Its name in the scene.
    pub name: String,
    /// The material; a texture is the index of an image.
    pub material: Material<usize>,
    /// What it was for.
    pub used_as: OldUse,
    /// Where it is defined.
    pub origin: Origin,
}

/// An image of the scene.
#[derive(Clone, Debug)]
pub struct Image {
    /// Its name in the scene.
    pub name: String,
    /// Its file.
    pub path: PathBuf,
    /// Where it is named.
    pub origin: Origin,
}

/// What fills the world.
#[derive(Clone, Debug)]
pub struct Medium {
    /// Events per unit of length.
    pub rate: f32,
    /// The share of light that is scattered on.
    pub albedo: Spectrum,
    /// Where it is defined.
    pub origin: Origin,
}

impl Materials {
    /// Adds what must be stated of the materials that a mesh file uses: of each its name there and in the scene. What has another
    /// in its place becomes plain, so that nobody misses its pictures.
    pub fn add(
        &mut self,
        mesh: &mut MeshFile,
        search: &Search,
        sources: &SourceMap,
        found: &mut Diagnostics,
    ) -> Vec<[String; 2]> {
        let mut replaced = Vec::new();
        for named in &mut mesh.materials {
            let Some(origin) = &named.origin else { continue };
            let Some(old) = self.old(origin, sources) else { continue };
            let is_brushed = matches!(old.used_as, OldUse::Brushed(_));
            if *old.named.material == *named.material && !is_brushed {
                continue;
            }
            let surface = match self.stated.get(origin) {
                Some(&surface) => surface,
                None => self.state(old, origin, search, sources, found),
            };
            *named.material = MeshFile::default_material(&named.name);
            replaced.push([named.name.clone(), self.surfaces[surface].name.clone()]);
        }
        replaced
    }

    /// Takes the medium from the libraries among some files.
    pub fn look_for_medium(&mut self, files: impl Iterator<Item = FileId>, sources: &SourceMap) {
        for file in files.filter(|&file| MeshFormat::of_path(sources.path(file)).is_none()) {
            let materials = self.library(file, sources);
            let medium = materials.iter().find_map(|old| match (old.used_as, &old.named.origin) {
                (OldUse::Medium { rate, albedo }, Some(origin)) if rate > 0.0 => {
                    Some(Medium { rate, albedo, origin: origin.clone() })
                }
                _ => None,
            });
            self.medium = self.medium.take().or(medium);
        }
    }

    fn library(&mut self, file: FileId, sources: &SourceMap) -> &[OldMaterial] {
        self.libraries.entry(file).or_insert_with(|| mtl::read_old(&sources.bytes(file), file))
    }

    /// The material that is defined at `origin`, if that is in a library.
    fn old(&mut self, origin: &Origin, sources: &SourceMap) -> Option<OldMaterial> {
        let file = origin.span()?.file;
        if MeshFormat::of_path(sources.path(file)).is_some() {
            return None;
        }
        self.library(file, sources).iter().find(|old| old.named.origin.as_ref() == Some(origin)).cloned()
    }

    fn state(
        &mut self,
        old: OldMaterial,
        origin: &Origin,
        search: &Search,
        sources: &SourceMap,
        found: &mut Diagnostics,
    ) -> usize {
        let library = origin.span().map(|span| sources.path(span.file).to_owned()).unwrap_or_default();
        let folder = library.parent().unwrap_or(Path::new(""));
        let brushed = matches!(old.used_as, OldUse::Brushed(_));
        let material = old.named.material.map_textures(&mut |texture, _| {
            // Nobody looks at the picture of a brushed surface.
            (!brushed).then(|| self.image(texture, folder, search, found)).flatten()
        });
        let name = unused_name(&old.named.name, |name| self.surfaces.iter().any(|s| s.name == name));
        self.surfaces.push(Surface { name, material, used_as: old.used_as, origin: origin.clone() });
        self.stated.insert(origin.clone(), self.surfaces.len() - 1);
        self.surfaces.len() - 1
    }

    fn image(
        &mut self,
        texture: &TextureRecord,
        folder: &Path,
        search: &Search,
        found: &mut Diagnostics,
    ) -> Option<usize> {
        let image = texture.first_image()?;
        let name = image.file.value.to_string_lossy();
        let beside = || find_file(folder, &name).ok().map(|(path, _)| path);
        let Some(path) = search.find(&name).or_else(beside) else {
            let warning = Diagnostic::warning(format!("no such file: {}", folder.join(&*name).display()));
            found.push(warning.at(image.file.origin.clone()).label("the material goes without it"));
            return None;
        };
        if let Some(known) = self.images.iter().position(|image| image.path == path) {
            return Some(known);
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let name = unused_name(&stem, |name| self.images.iter().any(|image| image.name == name));
        self.images.push(Image { name, path, origin: image.file.origin.clone() });
        Some(self.images.len() - 1)
    }
}

/// The name, with a number if it is taken.
pub fn unused_name(name: &str, is_used: impl Fn(&str) -> bool) -> String {
    let numbered = (2..).map(|number| format!("{name}-{number}"));
    std::iter::once(name.to_owned()).chain(numbered).find(|name| !is_used(name)).unwrap_or_default()
}
