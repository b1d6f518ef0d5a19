//! From `[media.NAME]` to media: volumes loaded, boxes placed.

use super::{meshes::Loader, usable};
use crate::{
    Diagnostic,
    description::{DensityRecord, EnvironmentRecord, Located, MediumRecord, SceneDescription},
    find_file::find_file,
    geometry,
    import::counted,
    volume_file::{Axes, RawLayout, decode_volume},
};
use etendue::{
    math::{DAffine3, DVec3},
    medium::{Density, DensityGrid, Medium},
    scene::DeltaLight,
};
use std::{path::PathBuf, sync::Arc};

/// A volume that has been read; `None`: it could not be, which has been reported.
type Known = (PathBuf, Option<RawLayout>, Option<Axes>, Option<Arc<DensityGrid>>);

impl Loader<'_> {
    /// The media, each volume read once. What is wrong is reported.
    pub fn media(&mut self) -> Vec<Medium> {
        let description = self.description;
        let mut known = Vec::new();
        let media = description.media.iter().map(|record| self.medium(record, &mut known)).collect();
        self.check_world(description);
        media
    }

    fn medium(&mut self, record: &MediumRecord, known: &mut Vec<Known>) -> Medium {
        let density = record.density.as_ref().and_then(|density| self.density(density, known));
        Medium { density, ..record.medium.clone() }
    }

    fn density(&mut self, record: &DensityRecord, known: &mut Vec<Known>) -> Option<Density> {
        let grid = self.volume(record, known)?;
        let place = || record.file.origin.clone();
        let mut to_world = DAffine3::from_translation(record.min) * DAffine3::from_scale(record.max - record.min);
        for step in &record.transform {
            to_world = geometry::step(&step.value, || DVec3::ZERO) * to_world;
            if !to_world.is_finite() || !usable(&to_world) {
                let message = "the transform is too large, or flattens the box";
                self.findings.push(Diagnostic::error(message).at(step.origin.clone()));
                return None;
            }
        }
        match Density::new(grid, to_world, record.scale) {
            Ok(density) => Some(density),
            Err(error) => {
                self.findings.push(Diagnostic::error(error.to_string()).at(place()));
                None
            }
        }
    }

    fn volume(&mut self, record: &DensityRecord, known: &mut Vec<Known>) -> Option<Arc<DensityGrid>> {
        let DensityRecord { file, layout, axes, .. } = record;
        let same = |k: &&Known| k.0 == file.value && k.1 == *layout && k.2 == *axes;
        if let Some((.., grid)) = known.iter().find(same) {
            return grid.clone();
        }
        let grid = self.read_volume(file, layout.as_ref(), *axes).map(Arc::new);
        known.push((file.value.clone(), *layout, *axes, grid.clone()));
        grid
    }

    fn read_volume(
        &mut self,
        file: &Located<PathBuf>,
        layout: Option<&RawLayout>,
        axes: Option<Axes>,
    ) -> Option<DensityGrid> {
        let place = || file.origin.clone();
        let (path, note) = match find_file(&self.description.folder, &file.value.to_string_lossy()) {
            Ok(found) => found,
            Err(error) => {
                self.findings.push(Diagnostic::error(error.to_string()).at(place()));
                return None;
            }
        };
        self.findings.extend(note.map(|note| Diagnostic::note(note).at(place())));
        let limits = &self.limits.volumes;
        let bytes = match self.sources.read(&path, limits.file) {
            Ok(source) => self.sources.bytes(source),
            Err(error) => {
                self.findings.push(Diagnostic::error(error.to_string()).at(place()));
                return None;
            }
        };
        match decode_volume(&path, &bytes, layout, axes, limits) {
            Ok(grid) => {
                if grid.repaired() > 0 {
                    let count = counted(grid.repaired() as usize, "value");
                    let message = format!("{count} of the volume are negative or not finite");
                    self.findings.push(Diagnostic::warning(message).at(place()).label("they count as 0"));
                }
                Some(grid)
            }
            Err(error) => {
                let finding = Diagnostic::error(error.to_string()).at(place());
                self.findings.push(match error.help() {
                    Some(help) => finding.help(help),
                    None => finding,
                });
                None
            }
        }
    }

    /// Warns of what a medium without end does.
    fn check_world(&mut self, description: &SceneDescription) {
        let Some(world) = &description.world_medium else { return };
        let Some(record) = description.media.iter().find(|record| record.medium.name == world.value) else { return };
        let mut warn = |message: String, help: &str| {
            self.findings.push(Diagnostic::warning(message).at(world.origin.clone()).help(help));
        };
        let Medium { name, .. } = &record.medium;
        if record.density.is_some() {
            return;
        }
        if record.medium.glows_without_bound() {
            let message = format!("`{name}` glows and weakens nothing, and fills a world without end");
            warn(message, "its light is infinite where no surface stops a ray: give it some `absorption`");
        }
        let from_afar = description.lights.iter().any(|l| matches!(l.value, DeltaLight::Directional { .. }))
            || !matches!(
                &description.environment,
                None | Some(EnvironmentRecord::Constant(etendue::spectrum::Spectrum::BLACK))
            );
        if from_afar && record.medium.extinction().min_component() > 0.0 {
            let message = format!("light from infinity never arrives: `{name}` fills a world without end");
            warn(message, "fill a body instead, by a material's `interior`");
        }
    }
}
