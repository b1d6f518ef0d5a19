//! Pictures as their files store them.

use super::srgb;
use etendue::{
    image::{Channel, ChannelData, Image},
    texture::{self, TextureImage, TextureImageError, Transfer},
};

/// Samples of a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// 0 to 255 stands for 0 to 1.
    U8(Vec<u8>),
    /// 0 to 65535 stands for 0 to 1.
    U16(Vec<u16>),
    /// The values; may be anything, also NaN.
    F32(Vec<f32>),
}

impl Samples {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(samples) => samples.len(),
            Self::U16(samples) => samples.len(),
            Self::F32(samples) => samples.len(),
        }
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A picture as its file stores it: pixel by pixel, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct RawImage {
    /// Pixels across, at least 1.
    pub width: u32,
    /// Pixels down, at least 1.
    pub height: u32,
    /// 1 grey, 2 grey and alpha, 3 red, green and blue, 4 these and alpha. Alpha is linear and straight.
    pub channels: u8,
    /// `width * height * channels` of them.
    pub samples: Samples,
    /// The colours are sRGB-encoded (IEC 61966-2-1); else linear. Primaries are those of Rec. 709.
    pub encoded_srgb: bool,
}

impl RawImage {
    /// True if the last channel is alpha.
    pub fn has_alpha(&self) -> bool {
        self.channels.is_multiple_of(2)
    }

    /// As the renderer looks it up.
    ///
    /// # Errors
    /// If a sample is not finite.
    pub fn into_texture(self) -> Result<TextureImage, TextureImageError> {
        let samples = match self.samples {
            Samples::U8(samples) => texture::Samples::U8(samples.into()),
            Samples::U16(samples) => texture::Samples::U16(samples.into()),
            Samples::F32(samples) => texture::Samples::F32(samples.into()),
        };
        let transfer = if self.encoded_srgb { Transfer::Srgb } else { Transfer::Linear };
        TextureImage::new(self.width, self.height, usize::from(self.channels), samples, transfer)
    }

    /// Linear `R G B`, and `A` premultiplied if there is alpha.
    pub(super) fn into_image(self) -> Image {
        let colours = if self.encoded_srgb { srgb::to_linear } else { |v| v };
        match &self.samples {
            Samples::U8(samples) => {
                let table: Vec<f32> = (0..256).map(|v| colours(f64::from(v) / 255.0) as f32).collect();
                self.planes(samples, |v| table[usize::from(v)], |v| f32::from(v) / 255.0)
            }
            Samples::U16(samples) => {
                let table: Vec<f32> = (0..65_536).map(|v| colours(f64::from(v) / 65_535.0) as f32).collect();
                self.planes(samples, |v| table[usize::from(v)], |v| f32::from(v) / 65_535.0)
            }
            Samples::F32(samples) => self.planes(samples, |v| colours(f64::from(v)) as f32, |v| v),
        }
    }

    fn planes<T: Copy>(&self, samples: &[T], colour: impl Fn(T) -> f32, alpha: impl Fn(T) -> f32) -> Image {
        let channels = usize::from(self.channels);
        let pixels = || samples.chunks_exact(channels);
        let alphas: Option<Vec<f32>> = self.has_alpha().then(|| pixels().map(|p| alpha(p[channels - 1])).collect());
        let plane = |c: usize| -> Vec<f32> {
            let values = pixels().map(|p| colour(p[c]));
            match &alphas {
                Some(alphas) => values.zip(alphas).map(|(value, alpha)| value * alpha).collect(),
                None => values.collect(),
            }
        };
        let planes: Vec<Vec<f32>> = if channels < 3 { vec![plane(0); 3] } else { (0..3).map(plane).collect() };
        let named = ["R", "G", "B", "A"].into_iter().zip(planes.into_iter().chain(alphas));
        let channels = named.map(|(name, data)| Channel { name: name.to_owned(), data: ChannelData::F32(data) });
        Image { width: self.width, height: self.height, channels: channels.collect() }
    }

    /// The colour of a picture of named channels, with its premultiplied alpha made straight: `R G B` or `Y`, of the
    /// first layer by name where colours stand only in layers (`view.R`); else the only channel. `None` if it has no such.
    pub(super) fn of_image(image: &Image) -> Option<Self> {
        let (colours, alpha) = colour_channels(image)?;
        let mut samples = Vec::with_capacity((colours.len() + usize::from(alpha.is_some())) * colours[0].len());
        for pixel in 0..colours[0].len() {
            let cover = alpha.map_or(1.0, |alpha| alpha[pixel]);
            // What nothing covers may still have a colour: light that is added.
            let scale = if cover > 0.0 { 1.0 / cover } else { 1.0 };
            samples.extend(colours.iter().map(|colour| colour[pixel] * scale));
            samples.extend(alpha.map(|alpha| alpha[pixel]));
        }
        Some(Self {
            width: image.width,
            height: image.height,
            channels: colours.len() as u8 + u8::from(alpha.is_some()),
            samples: Samples::F32(samples),
            encoded_srgb: false,
        })
    }
}

/// One or three channels of colour, and alpha.
type Colours<'a> = (Vec<&'a [f32]>, Option<&'a [f32]>);

fn colour_channels(image: &Image) -> Option<Colours<'_>> {
    let of_layer = |layer: &str| {
        let channel = |name: &str| image.f32_channel(&format!("{layer}{name}"));
        let rgb: Option<Vec<&[f32]>> = ["R", "G", "B"].into_iter().map(channel).collect();
        Some((rgb?, channel("A")))
    };
    let grey = || Some((vec![image.f32_channel("Y")?], image.f32_channel("A")));
    let layers = image.channels.iter().filter_map(|c| c.name.rfind('.').map(|dot| &c.name[..=dot]));
    let only = || match &image.channels[..] {
        [only] => image.f32_channel(&only.name).map(|grey| (vec![grey], None)),
        _ => None,
    };
    of_layer("").or_else(grey).or_else(|| layers.into_iter().find_map(of_layer)).or_else(only)
}
