//! What pictures say about how they were made, without their pixels.

use exr::meta::{MetaData, attribute::AttributeValue};
use std::{fs::File, io::BufReader, path::Path};

/// Most bytes of all texts of a file.
const MOST: usize = 16 << 20;

/// Names and texts of a PNG file's entries; `None` if it is no such file.
pub fn of_png(path: &Path) -> Option<Vec<(String, String)>> {
    let file = BufReader::new(File::open(path).ok()?);
    let reader = png::Decoder::new_with_limits(file, png::Limits { bytes: MOST }).read_info().ok()?;
    let info = reader.info();
    let plain = info.uncompressed_latin1_text.iter().map(|chunk| (chunk.keyword.clone(), chunk.text.clone()));
    let wide = info.utf8_text.iter().filter_map(|chunk| Some((chunk.keyword.clone(), chunk.get_text().ok()?)));
    Some(plain.chain(wide).collect())
}

/// Names and texts of an EXR file's first part; `None` if it is no such file.
pub fn of_exr(path: &Path) -> Option<Vec<(String, String)>> {
    let file = BufReader::new(File::open(path).ok()?);
    let meta = MetaData::read_from_buffered(file, false).ok()?;
    let text = |(name, value): (&exr::meta::attribute::Text, &AttributeValue)| match value {
        AttributeValue::Text(value) => Some((name.to_string(), value.to_string())),
        _ => None,
    };
    Some(meta.headers.first()?.own_attributes.other.iter().filter_map(text).collect())
}
