//! Developed pictures: named channels in scan-line order.

/// The samples of one channel, row by row from the top left, `width * height` of them.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelData {
    /// Linear values.
    F32(Vec<f32>),
    /// Ids, never filtered.
    U32(Vec<u32>),
}

/// One channel of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The name it has in an EXR file: `R`, `G`, `B`, `Albedo.R`, `N.X`, `Depth.Z`, `Variance.R`, ...
    pub name: String,
    /// Its samples.
    pub data: ChannelData,
}

/// A picture: colour is linear sRGB (Rec. 709 primaries).
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Channels, `R G B` first where there is colour.
    pub channels: Vec<Channel>,
}

impl Image {
    /// The samples of the channel with this name, if it is there and holds floats.
    pub fn f32_channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find_map(|c| match &c.data {
            ChannelData::F32(data) if c.name == name => Some(&data[..]),
            _ => None,
        })
    }
}
