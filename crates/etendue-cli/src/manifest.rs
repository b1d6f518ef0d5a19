//! Names for the ids in a picture.

use etendue::{
    image::{ChannelData, Image},
    material::Material,
};
use etendue_scene::output::Metadata;
use std::collections::BTreeMap;

/// Adds the names behind the numbers of `Id.Object` and `Id.Material`, of those that occur in the picture, as JSON objects
/// from number to name. A picture without ids gets none.
pub fn add(metadata: Metadata, image: &Image, objects: &[String], materials: &[Material]) -> Metadata {
    let metadata = entry(metadata, "idObjectNames", ids(image, "Id.Object"), |i| objects.get(i).map(String::as_str));
    entry(metadata, "idMaterialNames", ids(image, "Id.Material"), |i| materials.get(i).map(|m| m.name.as_str()))
}

fn ids<'a>(image: &'a Image, name: &str) -> Option<&'a [u32]> {
    image.channels.iter().find_map(|channel| match &channel.data {
        ChannelData::U32(ids) if channel.name == name => Some(&ids[..]),
        _ => None,
    })
}

fn entry<'a>(
    metadata: Metadata,
    name: &str,
    ids: Option<&[u32]>,
    name_of: impl Fn(usize) -> Option<&'a str>,
) -> Metadata {
    let Some(ids) = ids else { return metadata };
    let mut names = BTreeMap::new();
    let mut last = 0;
    for &id in ids {
        // Neighbours are mostly alike.
        if id != last
            && id != 0
            && let Some(name) = name_of(id as usize - 1)
        {
            names.insert(id, name);
        }
        last = id;
    }
    metadata.with(name, serde_json::to_string(&names).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::image::Channel;

    #[test]
    fn names_of_what_is_seen() {
        let channel = |name: &str, ids: Vec<u32>| Channel { name: name.to_owned(), data: ChannelData::U32(ids) };
        let channels = vec![channel("Id.Object", vec![0, 3, 3, 1, 9])];
        let image = Image { width: 5, height: 1, channels };
        let names = ["a \"quoted\"", "unseen", "c"].map(str::to_owned);
        let metadata = add(Metadata::default(), &image, &names, &[]);
        assert_eq!(metadata.get("idObjectNames"), Some(r#"{"1":"a \"quoted\"","3":"c"}"#));
        assert_eq!(metadata.get("idMaterialNames"), None);
    }
}
