//! Image files of textures: each read once, whatever refers to it.

use super::ahead::{Decoded, decode_ahead};
use crate::{
    Diagnostic, Diagnostics, Limits, Severity, SourceMap,
    description::{ImageRecord, TextureRecord},
    find_file::find_file,
    image_file::decode_texture,
    import::LoadedTexture,
};
use etendue::{
    material::Material,
    texture::{Texture, TextureImage, Transfer},
};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
    sync::Arc,
};

/// Where textures come from, and where findings go.
pub struct TextureFiles<'a> {
    /// Where relative names start.
    pub folder: &'a Path,
    /// How bad it is if an image cannot be read.
    pub missing: Severity,
    /// Gets the files' bytes.
    pub sources: &'a mut SourceMap,
    /// Bounds on what is read.
    pub limits: &'a Limits,
    /// What was found.
    pub findings: &'a mut Diagnostics,
}

/// The images read so far.
#[derive(Debug, Default)]
pub struct Textures {
    /// By path; `None`: could not be read, which has been reported.
    files: BTreeMap<PathBuf, Option<Arc<TextureImage>>>,
    /// Those with another meaning than they were read with.
    others: BTreeMap<PathBuf, Arc<TextureImage>>,
    /// Those that wait for the material that names them.
    ahead: BTreeMap<PathBuf, Decoded>,
}

impl Textures {
    /// Those that have been read.
    pub fn of(images: &[LoadedTexture]) -> Self {
        let files = images.iter().map(|texture| (texture.path.clone(), Some(texture.image.clone()))).collect();
        Self { files, ..Self::default() }
    }

    /// Reads the images of materials, several at once, with the folders that names are relative to. They wait until
    /// [`Textures::load`] asks for them, in whose order files are added and findings reported.
    pub fn read_ahead<'m>(
        &mut self,
        materials: impl Iterator<Item = (&'m Path, &'m Material<TextureRecord>)>,
        sources: &SourceMap,
        limits: &Limits,
    ) {
        let (mut paths, mut seen) = (Vec::new(), BTreeSet::new());
        for (folder, material) in materials {
            material.map_textures(&mut |record, _| -> Option<()> {
                let mut images = Vec::new();
                record.images(&mut images);
                let found = images.iter().map(|image| find_file(folder, &image.file.value.to_string_lossy()));
                paths.extend(found.flatten().map(|(path, _)| path).filter(|path| seen.insert(path.clone())));
                None
            });
        }
        paths.retain(|path| !self.files.contains_key(path) && sources.find(path).is_none());
        self.ahead = decode_ahead(paths, &limits.images);
    }

    /// A material all of whose images have been read, by names relative to `folder`.
    pub fn material(&mut self, material: &Material<TextureRecord>, folder: &Path) -> Material {
        let (mut sources, limits, mut findings) = (SourceMap::new(), Limits::default(), Diagnostics::new());
        let (sources, findings) = (&mut sources, &mut findings);
        let mut files = TextureFiles { folder, missing: Severity::Warning, sources, limits: &limits, findings };
        material.map_textures(&mut |record, transfer| self.load(record, transfer, &mut files))
    }

    /// The images, by path.
    pub fn images(&self) -> impl Iterator<Item = LoadedTexture> + '_ {
        let read = self.files.iter().filter_map(|(path, image)| Some((path, image.as_ref()?)));
        read.map(|(path, image)| LoadedTexture { path: path.clone(), image: image.clone() })
    }

    /// The texture of a record; `transfer` is what its samples mean if the record does not say. `None` if an image of it cannot
    /// be read, which is reported.
    pub fn load(
        &mut self,
        record: &TextureRecord,
        transfer: Transfer,
        files: &mut TextureFiles,
    ) -> Option<Arc<Texture>> {
        record.try_map(transfer, &mut |image, transfer| self.image(image, transfer, files)).map(Arc::new)
    }

    fn image(
        &mut self,
        record: &ImageRecord,
        transfer: Transfer,
        files: &mut TextureFiles,
    ) -> Option<Arc<TextureImage>> {
        let (path, note) = match find_file(files.folder, &record.file.value.to_string_lossy()) {
            Ok(found) => found,
            Err(error) => return files.report(error.to_string(), record),
        };
        if !self.files.contains_key(&path) {
            if let Some(note) = note {
                files.findings.push(Diagnostic::note(note).at(record.file.origin.clone()));
            }
            let image = match read(&path, self.ahead.remove(&path), files) {
                Ok(image) => Some(image),
                Err(message) => files.report(message, record),
            };
            self.files.insert(path.clone(), image);
        }
        let stored = self.files.get(&path)?.as_ref()?;
        let transfer = record.transfer.unwrap_or(transfer);
        if stored.transfer() == transfer {
            return Some(stored.clone());
        }
        let other = || Arc::new(stored.with_transfer(transfer));
        Some(self.others.entry(path).or_insert_with(other).clone())
    }
}

impl TextureFiles<'_> {
    fn report<T>(&mut self, message: String, record: &ImageRecord) -> Option<T> {
        let finding = Diagnostic { severity: self.missing, ..Diagnostic::error(message) };
        let finding = finding.at(record.file.origin.clone());
        self.findings.push(match self.missing {
            Severity::Error => finding,
            _ => finding.label("the material goes without it"),
        });
        None
    }
}

fn read(path: &Path, ahead: Option<Decoded>, files: &mut TextureFiles) -> Result<Arc<TextureImage>, String> {
    if let Some(Decoded { bytes, image }) = ahead {
        files.sources.insert(path, bytes).map_err(|error| error.to_string())?;
        return Ok(image);
    }
    let limits = &files.limits.images;
    let file = files.sources.read(path, limits.file).map_err(|error| error.to_string())?;
    let bytes = files.sources.bytes(file);
    let image = decode_texture(path, &bytes, limits).map_err(|error| error.to_string())?;
    match image.into_texture() {
        Ok(image) => Ok(Arc::new(image)),
        Err(error) => Err(format!("{}: {error}", path.display())),
    }
}
