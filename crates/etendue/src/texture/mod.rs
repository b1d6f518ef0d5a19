//! Textures: images and procedures that give surface parameters.

mod image;
mod lookup;
mod mapping;
mod parameter;
mod procedural;
mod pyramid;
mod sample;

pub use image::{Samples, TextureImage, TextureImageError, Transfer};
pub use lookup::{Footprint, Lookup, RayCone};
pub use mapping::{Channel, Filtering, Mapping, UvTransform, Wrap};
pub use parameter::{Color, Number, Parameter};
pub use procedural::{Checker, Coordinates, Gradient, Grid, MAX_OCTAVES, Marble, Noise, Procedure, Stop, Wood};
pub use pyramid::Level;

use crate::{math::Vec2, spectrum::Spectrum};
use parameter::product;
use std::sync::Arc;

/// What a texture inside of another one is.
pub type Child<I> = Arc<Texture<I>>;

/// A function over a surface. `I` is what an image is: texels, or while a scene is read, the name of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture<I = Arc<TextureImage>> {
    /// What is on the surface.
    pub pattern: Pattern<I>,
    /// How coordinates become places in it, and what is there values.
    pub mapping: Mapping,
}

/// What textures are made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Pattern<I = Arc<TextureImage>> {
    /// Texels, shared between textures. Texture coordinate v points up: (0, 0) is the lower left corner of the image,
    /// (1, 1) the upper right one.
    Image(I),
    /// Two colours, mixed by a procedure.
    Procedure {
        /// Which share the second colour has.
        procedure: Procedure,
        /// What it is a function of.
        coordinates: Coordinates,
        /// Where the share is 0, and where it is 1.
        colors: [Color<Child<I>>; 2],
    },
    /// Colours along a line or about a point.
    Gradient(Gradient),
    /// `(1 - weight) colors[0] + weight colors[1]`.
    Mix {
        /// What is mixed.
        colors: [Color<Child<I>>; 2],
        /// Share of the second, brought into [0, 1].
        weight: Number<Child<I>>,
    },
    /// The product of two colours.
    Multiply([Color<Child<I>>; 2]),
    /// The mesh's own colours, with their opacity.
    VertexColor,
}

impl<I> Pattern<I> {
    /// The name it has in files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Image(_) => "image",
            Self::Procedure { procedure, .. } => procedure.name(),
            Self::Gradient(_) => "gradient",
            Self::Mix { .. } => "mix",
            Self::Multiply(_) => "multiply",
            Self::VertexColor => "vertex-color",
        }
    }

    /// The textures inside.
    fn children(&self) -> impl Iterator<Item = &Texture<I>> {
        let (colors, weight) = match self {
            Self::Image(_) | Self::Gradient(_) | Self::VertexColor => (None, None),
            Self::Procedure { colors, .. } | Self::Multiply(colors) => (Some(colors), None),
            Self::Mix { colors, weight } => (Some(colors), Some(weight)),
        };
        let of_colors = colors.into_iter().flatten().filter_map(|color| color.texture.as_deref());
        of_colors.chain(weight.and_then(|weight| weight.texture.as_deref()))
    }
}

impl<I> Texture<I> {
    /// A pattern that is repeated, filtered and otherwise as it is.
    pub fn of(pattern: Pattern<I>) -> Self {
        Self { pattern, mapping: Mapping::default() }
    }

    /// The first image in it, in the order it was written.
    pub fn first_image(&self) -> Option<&I> {
        match &self.pattern {
            Pattern::Image(image) => Some(image),
            pattern => pattern.children().find_map(Self::first_image),
        }
    }

    /// All images in it, in the order they were written.
    pub fn images<'a>(&'a self, found: &mut Vec<&'a I>) {
        if let Pattern::Image(image) = &self.pattern {
            found.push(image);
        }
        self.pattern.children().for_each(|child| child.images(found));
    }

    /// The same texture with every image replaced; `None` where `load` gives none for one of them. `load` is told how the
    /// samples are to be understood: `transfer` for what gives the values, [`Transfer::Linear`] for weights.
    pub fn try_map<J>(
        &self,
        transfer: Transfer,
        load: &mut dyn FnMut(&I, Transfer) -> Option<J>,
    ) -> Option<Texture<J>> {
        let pattern = match &self.pattern {
            Pattern::Image(image) => Pattern::Image(load(image, transfer)?),
            Pattern::Procedure { procedure, coordinates, colors } => Pattern::Procedure {
                procedure: *procedure,
                coordinates: *coordinates,
                colors: map_colors(colors, transfer, load)?,
            },
            Pattern::Gradient(gradient) => Pattern::Gradient(gradient.clone()),
            Pattern::Mix { colors, weight } => Pattern::Mix {
                colors: map_colors(colors, transfer, load)?,
                weight: map_parameter(weight, Transfer::Linear, load)?,
            },
            Pattern::Multiply(colors) => Pattern::Multiply(map_colors(colors, transfer, load)?),
            Pattern::VertexColor => Pattern::VertexColor,
        };
        Some(Texture { pattern, mapping: self.mapping })
    }
}

fn map_parameter<V: Copy, I, J>(
    parameter: &Parameter<V, Child<I>>,
    transfer: Transfer,
    load: &mut dyn FnMut(&I, Transfer) -> Option<J>,
) -> Option<Parameter<V, Child<J>>> {
    let texture = match &parameter.texture {
        None => None,
        Some(texture) => Some(Arc::new(texture.try_map(transfer, load)?)),
    };
    Some(Parameter { factor: parameter.factor, texture })
}

fn map_colors<I, J>(
    [first, second]: &[Color<Child<I>>; 2],
    transfer: Transfer,
    load: &mut dyn FnMut(&I, Transfer) -> Option<J>,
) -> Option<[Color<Child<J>>; 2]> {
    Some([map_parameter(first, transfer, load)?, map_parameter(second, transfer, load)?])
}

impl Texture {
    /// An image that is repeated, filtered and otherwise as it is.
    pub fn new(image: Arc<TextureImage>) -> Self {
        Self::of(Pattern::Image(image))
    }

    /// The colour at a point, linear; grey where there is no colour.
    #[inline]
    pub fn color(&self, at: &Lookup) -> Spectrum {
        let [r, g, b, _] = self.lookup(at);
        let Mapping { base, gain, .. } = self.mapping;
        Spectrum([r, g, b].map(|value| base + gain * value))
    }

    /// The channel of [`Mapping::channel`] at a point.
    #[inline]
    pub fn number(&self, at: &Lookup) -> f32 {
        let Mapping { base, gain, channel, .. } = self.mapping;
        base + gain * channel.of(self.lookup(at))
    }

    /// Red, green, blue, opacity, before gain and base.
    fn lookup(&self, at: &Lookup) -> [f32; 4] {
        let opaque = |color: Spectrum| [color[0], color[1], color[2], 1.0];
        let mixed = |[first, second]: &[Color; 2], share: f32| match share {
            0.0 => first.at(at),
            1.0 => second.at(at),
            share => first.at(at) * (1.0 - share) + second.at(at) * share,
        };
        match &self.pattern {
            Pattern::Image(image) => sample::lookup(image, &self.mapping, at),
            Pattern::Procedure { procedure, coordinates, colors } => {
                let place = coordinates.place(&self.mapping.transform, at);
                opaque(mixed(colors, procedure.value(&place)))
            }
            Pattern::Gradient(gradient) => opaque(gradient.color(&self.mapping.transform, at)),
            Pattern::Mix { colors, weight } => opaque(mixed(colors, procedural::in_unit(weight.at(at)))),
            Pattern::Multiply([first, second]) => opaque(first.at(at) * second.at(at)),
            Pattern::VertexColor => at.color,
        }
    }

    /// Least and most that [`Self::number`] can be, or that a channel of [`Self::color`] can.
    pub fn range(&self) -> [f32; 2] {
        let Mapping { base, gain, channel, wrap, .. } = self.mapping;
        let hull = |[a, b]: [f32; 2], [c, d]: [f32; 2]| [a.min(c), b.max(d)];
        let [low, high] = match &self.pattern {
            Pattern::Image(image) => {
                let [low, high] = match channel {
                    Channel::Alpha if !image.is_translucent() => [1.0, 1.0],
                    Channel::Alpha => [0.0, 1.0],
                    _ => image.range(),
                };
                [if wrap.contains(&Wrap::Black) { low.min(0.0) } else { low }, high]
            }
            Pattern::VertexColor => [0.0, 1.0],
            _ if channel == Channel::Alpha => [1.0, 1.0],
            Pattern::Procedure { colors: [first, second], .. } | Pattern::Mix { colors: [first, second], .. } => {
                hull(first.range(), second.range())
            }
            Pattern::Gradient(gradient) => gradient.range(),
            Pattern::Multiply([first, second]) => product(first.range(), second.range()),
        };
        let (a, b) = (base + gain * low, base + gain * high);
        [a.min(b), a.max(b)]
    }

    /// Half the distance along u and v over which a slope is best taken as a difference: half a texel, or little of what a
    /// procedure does, but no less than half of the footprint. `None` if there is nothing with a slope.
    pub fn slope_steps(&self, at: &Lookup) -> Option<Vec2> {
        let finest = self.finest(at);
        if finest.x == f32::INFINITY && finest.y == f32::INFINITY {
            return None;
        }
        // Where it does not vary along one of them, any step will do.
        let or = |step: f32, other: f32| if step == f32::INFINITY { other } else { step };
        Some(Vec2::new(or(finest.x, finest.y), or(finest.y, finest.x)).max(at.uv_extent() * 0.5))
    }

    /// Half of the finest distance along u and v over which the texture changes; infinite where it does not.
    fn finest(&self, at: &Lookup) -> Vec2 {
        let own = match &self.pattern {
            Pattern::Image(image) => image.half_texel() / self.mapping.transform.scale().max(Vec2::splat(1e-6)),
            Pattern::Procedure { procedure, coordinates, .. } => {
                coordinates.steps(&self.mapping.transform, at) * procedure.finest()
            }
            Pattern::Gradient(gradient) => gradient.steps(&self.mapping.transform, at),
            Pattern::Mix { .. } | Pattern::Multiply(_) | Pattern::VertexColor => Vec2::INFINITY,
        };
        self.pattern.children().fold(own, |finest, child| finest.min(child.finest(at)))
    }

    /// Makes what filtered lookups need; see [`TextureImage::build_levels`].
    pub fn prepare(&self) {
        if let Pattern::Image(image) = &self.pattern
            && self.mapping.filtering == Filtering::Trilinear
        {
            image.build_levels();
        }
        self.pattern.children().for_each(Self::prepare);
    }

    /// Bytes of the image, if it is one that is read without coarser copies; else 0.
    pub(crate) fn unfiltered_bytes(&self) -> usize {
        match &self.pattern {
            Pattern::Image(image) if !self.is_filtered() => image.bytes(),
            _ => 0,
        }
    }

    /// Asks for the texels of an image at texture coordinates, which are looked up soon.
    #[inline]
    pub(crate) fn prefetch(&self, uv: Vec2) {
        if let Pattern::Image(image) = &self.pattern {
            sample::prefetch(image, &self.mapping, uv);
        }
    }

    /// True if a lookup's footprint makes a difference.
    pub fn is_filtered(&self) -> bool {
        match &self.pattern {
            Pattern::Image(_) => self.mapping.filtering == Filtering::Trilinear,
            Pattern::Procedure { .. } | Pattern::Gradient(_) => true,
            Pattern::Mix { .. } | Pattern::Multiply(_) | Pattern::VertexColor => {
                self.pattern.children().any(Self::is_filtered)
            }
        }
    }
}
