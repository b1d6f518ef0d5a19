//! Labels as files: OpenEXR, NumPy arrays, and JSON with what belongs to no pixel.

mod record;

pub use record::About;

use super::{EncodeError, Metadata, WriteError, atomic, exr, npy::Elements};
use etendue::{
    image::{Channel, ChannelData, Image},
    labels::{Labels, Way},
};
use std::{
    ffi::OsString,
    io::Write,
    path::{Path, PathBuf},
};

/// Which files the arrays of labels are written to; the JSON file is always there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LabelFormat {
    /// One OpenEXR file a frame, with a channel for each number.
    #[default]
    Exr,
    /// One NumPy array a frame and label.
    Npy,
    /// Both.
    Both,
}

impl LabelFormat {
    /// Every choice.
    pub const ALL: [Self; 3] = [Self::Exr, Self::Npy, Self::Both];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exr => "exr",
            Self::Npy => "npy",
            Self::Both => "both",
        }
    }
}

/// One array of labels.
struct Array<'a> {
    /// In the names of its files, and the channels that it has in an image.
    name: &'static str,
    channels: &'static [&'static str],
    elements: Elements<'a>,
}

/// The arrays that there are.
fn arrays(labels: &Labels) -> Vec<Array<'_>> {
    let array = |name, channels, elements| Array { name, channels, elements };
    let mut arrays = vec![
        array("object", &["Id.Object"], Elements::U32(&labels.object)),
        array("material", &["Id.Material"], Elements::U32(&labels.material)),
        array("face", &["Id.Face"], Elements::U32(&labels.face)),
        array("depth", &["Depth.Z"], Elements::F32(&labels.depth)),
        array("normal", &["N.X", "N.Y", "N.Z"], Elements::Triples(&labels.normal)),
        array("position", &["P.X", "P.Y", "P.Z"], Elements::Triples(&labels.position)),
        array("albedo", &["Albedo.R", "Albedo.G", "Albedo.B"], Elements::Triples(&labels.albedo)),
    ];
    for (way, flow) in Way::ALL.into_iter().zip(&labels.flow) {
        let Some(flow) = flow else { continue };
        let (names, channels, masks): ([&str; 2], &[&str], &[&str]) = match way {
            Way::Forward => {
                (["flow_forward", "occluded_forward"], &["Flow.Forward.X", "Flow.Forward.Y"], &["Occluded.Forward"])
            }
            Way::Backward => (
                ["flow_backward", "occluded_backward"],
                &["Flow.Backward.X", "Flow.Backward.Y"],
                &["Occluded.Backward"],
            ),
        };
        arrays.push(array(names[0], channels, Elements::Pairs(&flow.to)));
        arrays.push(array(names[1], masks, Elements::U8(&flow.occluded)));
    }
    arrays.retain(|array| array.elements.count() > 0);
    arrays
}

/// The labels as channels of an image: `Id.Object`, `Depth.Z`, `N.X`, `Flow.Forward.X`, ...
pub fn image_of(labels: &Labels) -> Image {
    let channels = arrays(labels).iter().flat_map(channels_of).collect();
    Image { width: labels.area.width(), height: labels.area.height(), channels }
}

fn channels_of(array: &Array<'_>) -> Vec<Channel> {
    let one = |axis: usize| match array.elements {
        Elements::U8(list) => ChannelData::U32(list.iter().map(|x| u32::from(*x)).collect()),
        Elements::U32(list) => ChannelData::U32(list.to_vec()),
        Elements::F32(list) => ChannelData::F32(list.to_vec()),
        Elements::Pairs(list) => ChannelData::F32(list.iter().map(|x| x[axis]).collect()),
        Elements::Triples(list) => ChannelData::F32(list.iter().map(|x| x[axis]).collect()),
    };
    let named = |(axis, name): (usize, &&str)| Channel { name: (*name).to_owned(), data: one(axis) };
    array.channels.iter().enumerate().map(named).collect()
}

/// Writes the labels of one frame, each file whole or not at all: `STEM.labels.exr`, `STEM.NAME.npy`, and at last
/// `STEM.labels.json`, so that all are there where that is. Returns their names.
///
/// # Errors
/// When a file cannot be written; those before it are there then.
pub fn write_labels(
    stem: &Path,
    format: LabelFormat,
    labels: &Labels,
    about: &About<'_>,
    metadata: &Metadata,
) -> Result<Vec<PathBuf>, WriteError> {
    let mut files = Vec::new();
    if format != LabelFormat::Npy {
        let path = with_ending(stem, "labels.exr");
        atomic::write(&path, |file| exr::write(file, &image_of(labels), metadata))?;
        files.push(path);
    }
    if format != LabelFormat::Exr {
        let shape = [labels.area.height() as usize, labels.area.width() as usize];
        for array in arrays(labels) {
            let path = with_ending(stem, &format!("{}.npy", array.name));
            atomic::write(&path, |file| super::npy::write(file, &shape, array.elements))?;
            files.push(path);
        }
    }
    let path = label_record(stem);
    let text = record::text(labels, about, &metadata.software, &files);
    atomic::write(&path, |file| file.write_all(text.as_bytes()).map_err(EncodeError::Io))?;
    files.push(path);
    Ok(files)
}

/// The JSON file of the labels whose files begin with `stem`.
pub fn label_record(stem: &Path) -> PathBuf {
    with_ending(stem, "labels.json")
}

/// Not `with_extension`: the dots in `frame.0001` are part of the name.
fn with_ending(stem: &Path, ending: &str) -> PathBuf {
    let mut name: OsString = stem.as_os_str().to_owned();
    name.push(".");
    name.push(ending);
    name.into()
}
