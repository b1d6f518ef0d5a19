//! From `[environment]` to light from all around.

use super::{meshes::Loader, sky};
use crate::{
    Diagnostic, Diagnostics,
    description::{EnvironmentRecord, Located, UpAxis},
    find_file::find_file,
    image_file::decode_image,
    read::rotation,
};
use etendue::{
    image::Image,
    light::RadianceMap,
    math::{DMat3, DVec3},
    scene::Environment,
    spectrum::Spectrum,
};
use std::{path::PathBuf, sync::Arc};

impl Loader<'_> {
    /// The environment; `None` if its image cannot be read, which is reported.
    pub fn environment(&mut self, record: &EnvironmentRecord) -> Option<Environment> {
        match record {
            EnvironmentRecord::Image { file, strength, rotation, up } => {
                let map = Arc::new(self.radiance_map(file)?);
                Some(Environment::Image { map, orientation: orientation(*up, *rotation), strength: *strength })
            }
            _ => without_image(record, &mut self.findings),
        }
    }

    fn radiance_map(&mut self, file: &Located<PathBuf>) -> Option<RadianceMap> {
        let report = |loader: &mut Self, finding: Diagnostic| loader.findings.push(finding.at(file.origin.clone()));
        let map = self.read_map(file);
        match map {
            Ok(map) if map.repaired() > 0 => {
                let count = map.repaired();
                let plural = if count == 1 { "" } else { "s" };
                let message = format!("{count} pixel{plural} of the environment are negative, not finite or too large");
                report(self, Diagnostic::warning(message).label("negative ones count as 0, infinite ones as 65504"));
                Some(map)
            }
            Ok(map) => Some(map),
            Err(message) => {
                report(self, Diagnostic::error(message));
                None
            }
        }
    }

    fn read_map(&mut self, file: &Located<PathBuf>) -> Result<RadianceMap, String> {
        let folder = &self.description.folder;
        let (path, note) = find_file(folder, &file.value.to_string_lossy()).map_err(|error| error.to_string())?;
        if let Some(note) = note {
            self.findings.push(Diagnostic::note(note).at(file.origin.clone()));
        }
        let limits = &self.limits.images;
        let source = self.sources.read(&path, limits.file).map_err(|error| error.to_string())?;
        let image = decode_image(&path, &self.sources.bytes(source), limits).map_err(|error| error.to_string())?;
        map_of(&image).map_err(|error| format!("{}: {error}", path.display()))
    }
}

/// An environment with other numbers, whose image, if it has one, is that of `before`.
pub fn environment_at(
    record: &EnvironmentRecord,
    before: Option<&Environment>,
    findings: &mut Diagnostics,
) -> Option<Environment> {
    match (record, before) {
        (EnvironmentRecord::Image { strength, rotation, up, .. }, Some(Environment::Image { map, .. })) => {
            Some(Environment::Image { map: map.clone(), orientation: orientation(*up, *rotation), strength: *strength })
        }
        (EnvironmentRecord::Image { .. }, _) => None,
        _ => without_image(record, findings),
    }
}

fn without_image(record: &EnvironmentRecord, findings: &mut Diagnostics) -> Option<Environment> {
    match record {
        EnvironmentRecord::Constant(radiance) => Some(Environment::Constant(*radiance)),
        EnvironmentRecord::Gradient { top, horizon, bottom, up } => {
            let map = RadianceMap::gradient(*top, *horizon, *bottom).ok()?;
            let orientation = orientation(*up, 0.0);
            Some(Environment::Image { map: Arc::new(map), orientation, strength: Spectrum::ONE })
        }
        EnvironmentRecord::Sky(record) => Some(sky::sky(record, findings)),
        EnvironmentRecord::Image { .. } => None,
    }
}

/// Colour, or grey where there is none.
fn map_of(image: &Image) -> Result<RadianceMap, String> {
    let channels = ["R", "G", "B"].map(|name| image.f32_channel(name));
    let texels: Vec<[f32; 3]> = match (channels, image.f32_channel("Y")) {
        ([Some(r), Some(g), Some(b)], _) => r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]).collect(),
        (_, Some(grey)) => grey.iter().map(|y| [*y; 3]).collect(),
        _ => return Err("the picture has no colour".to_owned()),
    };
    RadianceMap::new(image.width, image.height, texels).map_err(|error| error.to_string())
}

/// From a map's space, where y is up, to the world. Where z is up in the world, the middle of the map looks along -y.
fn orientation(up: UpAxis, angle: f64) -> DMat3 {
    let columns = |[x, y, z]: [DVec3; 3]| DMat3::from_cols(x, y, z);
    match up {
        UpAxis::Y => columns(rotation(DVec3::Y, angle)),
        UpAxis::Z => columns(rotation(DVec3::Z, angle)) * columns(rotation(DVec3::X, 90.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_a_map_and_its_top() {
        let middle_and_top = |up, angle| {
            let orientation = orientation(up, angle);
            (orientation.z_axis + DVec3::ZERO, orientation.y_axis + DVec3::ZERO)
        };
        assert_eq!(middle_and_top(UpAxis::Y, 0.0), (DVec3::Z, DVec3::Y));
        assert_eq!(middle_and_top(UpAxis::Y, 90.0), (DVec3::X, DVec3::Y));
        assert_eq!(middle_and_top(UpAxis::Z, 0.0), (DVec3::NEG_Y, DVec3::Z));
        assert_eq!(middle_and_top(UpAxis::Z, 90.0), (DVec3::X, DVec3::Z));
    }
}
