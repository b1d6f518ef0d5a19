//! Materials as the older renderer had them in the scenes of its scripts.

use super::{
    dialect,
    keys::Key,
    mapping::{BUMP_HEIGHT, LAMP, lamp},
    record::Record,
};
use crate::{FileId, Span, description::TextureRecord, mesh_file::NamedMaterial};
use etendue::{
    material::{Material, Parameter, Relief, Scattering},
    spectrum::Spectrum,
    texture::{Mapping, Pattern, Texture, Transfer},
};
use std::sync::Arc;

/// What names the medium that fills the world.
const MEDIUM: &str = "GlobalScatter";

/// A material of a library.
#[derive(Clone, Debug)]
pub(crate) struct OldMaterial {
    /// In the dialect, whatever the library's keys, and no other keys count; its textures are taken as they are stored, since
    /// the old program knew no transfer function.
    pub named: NamedMaterial,
    /// What it was for.
    pub used_as: OldUse,
}

/// What a material was for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum OldUse {
    /// A surface.
    Surface,
    /// A light source.
    Lamp,
    /// A surface with `bump`: a mirror of this colour whose normals spread along one direction.
    Brushed(Spectrum),
    /// The world's medium.
    Medium {
        /// Events per unit of length.
        rate: f32,
        /// The share of light that is scattered on.
        albedo: Spectrum,
    },
}

impl OldMaterial {
    /// What `record` was.
    pub fn new(record: &Record, file: FileId) -> Self {
        let mut material = Material::new(record.name.clone(), Scattering::Black);
        let mut used_as = OldUse::Surface;
        if record.name == LAMP {
            used_as = OldUse::Lamp;
            material.emission = lamp(record, &mut |_, _| {});
        } else {
            (material.scattering, _) = dialect::material(record, &mut |_, _| {});
            if let Some(map) = record.map(Key::Bump) {
                let height = Parameter { factor: BUMP_HEIGHT * map.bump, texture: Some(map.data()) };
                material.relief = Some(Relief::Bump { height });
            }
        }
        if let Scattering::Phong(lobes) = &mut material.scattering {
            // Nothing said that it is transparent.
            if record.number(Key::Transparency).unwrap_or(0.0) <= 0.0 {
                lobes.diffuse_transmission = Spectrum::BLACK.into();
                lobes.transmission = Spectrum::BLACK.into();
            }
            if material.relief.is_some() && !lobes.specular.factor.is_black() {
                used_as = OldUse::Brushed(lobes.specular.factor);
            }
        }
        if record.name == MEDIUM {
            let rate = record.number(Key::DialectIndex).unwrap_or(0.0);
            used_as = OldUse::Medium { rate, albedo: Spectrum(record.colour(Key::Diffuse).unwrap_or_default()) };
        }
        let material = material.map_textures(&mut |texture: &TextureRecord, _| {
            let mut pattern = texture.pattern.clone();
            if let Pattern::Image(image) = &mut pattern {
                image.transfer = Some(Transfer::Linear);
            }
            Some(Arc::new(Texture { pattern, mapping: Mapping::default() }))
        });
        let origin = Some(Span::new(file, record.place.clone()).into());
        let named = NamedMaterial { name: record.name.clone(), material: Box::new(material), origin };
        Self { named, used_as }
    }
}
