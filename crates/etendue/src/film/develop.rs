//! From sums to an image.

use super::{
    Aov, PixelRect,
    layers::{Layers, Plan, Quantity},
    sums::{ColourSums, LIGHT, mean},
};
use crate::image::{Channel, ChannelData, Image};

/// Channels while they are developed, pixel by pixel.
pub(super) struct Planes<'a> {
    plan: &'a Plan,
    aovs: &'a [Aov],
    /// `R G B`, and `A` of a transparent picture.
    colour: Vec<Vec<f32>>,
    /// By layer and channel; empty for layers of integers.
    floats: Vec<Vec<Vec<f32>>>,
    /// By layer and channel; empty for layers of floats.
    integers: Vec<Vec<Vec<u32>>>,
}

fn is_integer(aov: Aov) -> bool {
    matches!(aov, Aov::Ids | Aov::Samples)
}

impl<'a> Planes<'a> {
    pub fn new(plan: &'a Plan, aovs: &'a [Aov], transparent: bool, pixels: usize) -> Self {
        let channels = |aov: &Aov, wanted: bool| if wanted { aov.channels().len() } else { 0 };
        Self {
            plan,
            aovs,
            colour: vec![Vec::with_capacity(pixels); if transparent { 4 } else { 3 }],
            floats: aovs.iter().map(|a| vec![Vec::with_capacity(pixels); channels(a, !is_integer(*a))]).collect(),
            integers: aovs.iter().map(|a| vec![Vec::with_capacity(pixels); channels(a, is_integer(*a))]).collect(),
        }
    }

    /// Develops pixel `at` of a row.
    pub fn push(&mut self, colour: &ColourSums, layers: &Layers, at: usize) {
        let (plan, samples) = (self.plan, colour.samples());
        for (channel, plane) in self.colour.iter_mut().enumerate() {
            plane.push(match channel {
                3 => layers.mean(plan, at, Quantity::Alpha, 0, samples),
                channel => colour.mean(channel),
            });
        }
        for (aov, planes) in self.aovs.iter().zip(&mut self.floats) {
            for (i, plane) in planes.iter_mut().enumerate() {
                plane.push(float(*aov, i, plan, colour, layers, at));
            }
        }
        for (aov, planes) in self.aovs.iter().zip(&mut self.integers) {
            for (i, plane) in planes.iter_mut().enumerate() {
                plane.push(if *aov == Aov::Samples { samples } else { layers.ids(at)[i] });
            }
        }
    }

    pub fn into_image(self, area: PixelRect) -> Image {
        let colour = ["R", "G", "B", "A"].into_iter().zip(self.colour);
        let colour = colour.map(|(name, data)| (name, ChannelData::F32(data)));
        let layers = self.aovs.iter().zip(self.floats).zip(self.integers).flat_map(|((aov, floats), integers)| {
            let floats = floats.into_iter().map(ChannelData::F32);
            aov.channels().iter().copied().zip(floats.chain(integers.into_iter().map(ChannelData::U32)))
        });
        let channels = colour.chain(layers).map(|(name, data)| Channel { name: name.to_owned(), data }).collect();
        Image { width: area.width(), height: area.height(), channels }
    }
}

/// Number `i` of a layer of floats.
fn float(aov: Aov, i: usize, plan: &Plan, colour: &ColourSums, layers: &Layers, at: usize) -> f32 {
    match (aov, Quantity::of(aov)) {
        (Aov::Variance, _) => colour.variance_of_mean(i),
        (Aov::Indirect, _) => {
            let direct = layers.sum(plan, at, Quantity::Direct, i);
            mean(colour.sum[i] - direct, colour.samples(), LIGHT)
        }
        (_, Some(quantity)) => layers.mean(plan, at, quantity, i, colour.samples()),
        (_, None) => 0.0,
    }
}
