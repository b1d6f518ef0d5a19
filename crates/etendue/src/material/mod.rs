//! What surfaces are made of.

mod check;
mod relief;
mod scattering;
mod tangent;

pub use crate::texture::{Color, Number, Parameter};
pub use check::MaterialError;
pub use relief::Relief;
pub use scattering::{INDEX_RANGE, Scattering};
pub use tangent::{Tangent, TangentField};

use crate::{
    bsdf::Bsdf,
    spectrum::Spectrum,
    texture::{Lookup, Texture, Transfer},
};
use std::{cell::RefCell, convert::Infallible, sync::Arc};

/// A surface's emission.
#[derive(Clone, Debug, PartialEq)]
pub struct Emission<T = Arc<Texture>> {
    /// Radiance, W sr^-1 m^-2 per channel, the same in all directions.
    pub radiance: Color<T>,
    /// Emits on both sides; otherwise only on the side that the geometric normal points to.
    pub two_sided: bool,
}

/// A surface's material. `T` is what a texture is: an image, or while a scene is read, the name of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Material<T = Arc<Texture>> {
    /// As in the file.
    pub name: String,
    /// How it scatters.
    pub scattering: Scattering<Color<T>, Number<T>>,
    /// What it emits.
    pub emission: Option<Emission<T>>,
    /// Fraction of the surface that is there, in [0, 1] (MTL `d`); the rest lets rays pass straight.
    pub opacity: Number<T>,
    /// Detail of the shading normal.
    pub relief: Option<Relief<T>>,
    /// Directions of what is anisotropic.
    pub tangent: TangentField<T>,
    /// Name of the medium that a closed surface of this material holds behind its normals; absent: what is outside is inside.
    pub interior: Option<String>,
    /// Where bodies overlap, the one with the larger number is there. With it, an index of refraction is that of the body
    /// itself; without, that of the inside over the outside, and the body counts as 0 among others.
    pub priority: Option<i32>,
}

impl<T> Material<T> {
    /// An opaque material that emits nothing and has no textures.
    pub fn new(name: impl Into<String>, scattering: Scattering) -> Self {
        let opacity = 1.0.into();
        Self {
            name: name.into(),
            scattering: scattering.into(),
            emission: None,
            opacity,
            relief: None,
            tangent: TangentField::default(),
            interior: None,
            priority: None,
        }
    }

    /// The same material with every texture replaced, or left out where `load` gives none. `load` is told how the samples are
    /// to be understood: colours are [`Transfer::Srgb`] where a file stores them so, numbers and normals are data.
    pub fn map_textures<U>(&self, load: &mut dyn FnMut(&T, Transfer) -> Option<U>) -> Material<U> {
        let load = RefCell::new(load);
        let image = |texture: &T, transfer| (load.borrow_mut())(texture, transfer);
        let color = |color: &Color<T>| Color {
            factor: color.factor,
            texture: color.texture.as_ref().and_then(|t| image(t, Transfer::Srgb)),
        };
        let number = |number: &Number<T>| Number {
            factor: number.factor,
            texture: number.texture.as_ref().and_then(|t| image(t, Transfer::Linear)),
        };
        let emission = self.emission.as_ref();
        let relief = match &self.relief {
            None => None,
            Some(Relief::Bump { height }) => Some(Relief::Bump { height: number(height) }),
            Some(Relief::Normals { map, scale }) => {
                image(map, Transfer::Linear).map(|map| Relief::Normals { map, scale: *scale })
            }
        };
        let scattering = self.scattering.try_map(|_, _, c| Ok::<_, Infallible>(color(c)), |_, _, n| Ok(number(n)));
        Material {
            name: self.name.clone(),
            scattering: scattering.unwrap_or_else(|never| match never {}),
            emission: emission.map(|e| Emission { radiance: color(&e.radiance), two_sided: e.two_sided }),
            opacity: number(&self.opacity),
            relief,
            tangent: TangentField { direction: self.tangent.direction, rotation: number(&self.tangent.rotation) },
            interior: self.interior.clone(),
            priority: self.priority,
        }
    }
}

impl Emission {
    /// Radiance at a point; what a texture would make negative is 0.
    #[inline]
    pub fn at(&self, at: &Lookup) -> Spectrum {
        self.radiance.at(at).map(|c| c.max(0.0))
    }
}

impl Material {
    /// Radiance at a point as light sampling sees it: where a surface is partly not there, so is its light.
    pub fn glow(&self, at: &Lookup) -> Spectrum {
        let opacity = self.opacity.at(at).clamp(0.0, 1.0);
        self.emission.as_ref().map_or(Spectrum::BLACK, |emission| emission.at(at) * opacity)
    }

    /// How a point of this material scatters. Meant for materials that passed [`validate`](Self::validate).
    #[inline]
    pub fn bsdf(&self, at: &Lookup) -> Bsdf {
        self.scattering.at(at).bsdf()
    }

    /// Textures of what filtered lookups are made for: all but emission and opacity, which light sampling and hits must
    /// find alike and so look up at points.
    pub(crate) fn filtered_textures(&self) -> Vec<Arc<Texture>> {
        let found = RefCell::new(Vec::new());
        let keep = |texture: &Option<Arc<Texture>>| found.borrow_mut().extend(texture.iter().cloned());
        let kept = self.scattering.try_map(
            |_, _, color| {
                keep(&color.texture);
                Ok::<_, Infallible>(())
            },
            |_, _, number| {
                keep(&number.texture);
                Ok(())
            },
        );
        kept.map_or_else(|never| match never {}, drop);
        match &self.relief {
            None => {}
            Some(Relief::Bump { height }) => keep(&height.texture),
            Some(Relief::Normals { map, .. }) => keep(&Some(map.clone())),
        }
        found.into_inner()
    }

    /// True if every ray is stopped, wherever it meets the surface.
    pub fn is_opaque(&self) -> bool {
        self.opacity.range()[0] >= 1.0
    }
}
