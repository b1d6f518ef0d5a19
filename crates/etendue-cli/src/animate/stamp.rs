//! By what a finished frame is known again.

use crate::{exit::Failure, load::Job, software};
use etendue_scene::{image_file::entries, output::Format};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// Name of the entry of a picture that says what it was made of.
pub const STAMP: &str = "frameStamp";
/// Name of the entry with the hash of the film.
pub const FILM_HASH: &str = "filmHash";

/// A hash of everything that a frame depends on.
pub fn stamp(job: &Job, times: &str) -> String {
    let mut hash = Sha256::new();
    let mut add = |text: &str| {
        hash.update((text.len() as u64).to_le_bytes());
        hash.update(text);
    };
    add(&software());
    add(&job.scene_hash);
    add(times);
    add(&format!("{:?}", job.film));
    add(&format!("{:?}", job.camera));
    let settings = &job.settings;
    add(&format!(
        "{:?}",
        (settings.spp, settings.seed, settings.max_depth, settings.splitting, settings.sampler, settings.integrator)
    ));
    add(&format!("{:?} {:?}", settings.filter, job.display));
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The hash of the film of a frame whose files are all there and carry the stamp.
pub fn finished(files: &[(PathBuf, Format)], stamp: &str) -> Result<Option<String>, Failure> {
    let mut hash = None;
    for (path, format) in files {
        match film_hash(path, *format, stamp) {
            Some(found) => hash = Some(found),
            None => return Ok(None),
        }
    }
    Ok(hash)
}

/// `None` where there is no such file, or one of another make.
fn film_hash(path: &Path, format: Format, stamp: &str) -> Option<String> {
    let entries = match format {
        Format::Png => entries::of_png(path)?,
        Format::Exr => entries::of_exr(path)?,
        Format::Hdr | Format::Pfm => return None,
    };
    let get = |name: &str| entries.iter().find(|(n, _)| n == name).map(|(_, text)| text.clone());
    (get(STAMP)? == stamp).then(|| get(FILM_HASH))?
}
