//! By what finished frames and films are known again.

use super::targets::FrameFile;
use crate::{exit::Failure, load::Job, software};
use etendue_scene::{animation::AnimationRecord, image_file::entries, output::Format, timeline::Moment};
use etendue_video::Settings;
use sha2::{Digest, Sha256};
use std::path::Path;

/// Name of the entry of a picture that says what it was made of.
pub const STAMP: &str = "frameStamp";
/// Name of the entry with the hash of the film.
pub const FILM_HASH: &str = "filmHash";

/// A hash of everything that a frame depends on. What physics makes of the scene depends on the scene's files and this program.
pub fn stamp(job: &Job, animation: &AnimationRecord, moment: Moment) -> String {
    let mut hash = Sha256::new();
    let mut add = |text: String| {
        hash.update((text.len() as u64).to_le_bytes());
        hash.update(text);
    };
    let Moment { time, shutter: [open, close] } = moment;
    let bits = [time, open, close, animation.start].map(f64::to_bits);
    let settings = &job.settings;
    add(software());
    add(job.scene_hash.clone());
    add(format!("{bits:?} {:?} {:?}", settings.shutter, animation.length));
    add(format!("{:?} {:?} {:?}", job.film, job.camera, settings.camera_motion));
    add(format!("{:?} {:?}", (settings.spp, settings.seed, settings.max_depth, settings.splitting), settings.sampler));
    add(format!("{:?} {:?} {:?}", settings.integrator, settings.filter, job.display));
    hexadecimal(hash)
}

/// A hash of everything that a film depends on: the stamps of its frames, and how it is encoded.
pub fn of_film(frames: impl Iterator<Item = Result<String, Failure>>, settings: Settings) -> Result<String, Failure> {
    let mut hash = Sha256::new();
    let Settings { size, rate, frames: count, quality } = settings;
    hash.update(format!("{size:?} {rate} {count} {quality}"));
    for frame in frames {
        hash.update(frame?);
    }
    Ok(hexadecimal(hash))
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// What the note of a film begins with.
const NOTE: &str = "etendue-film 1";

/// The note of a film: its stamp and the hashes of its frames.
pub fn note(made: &str, hashes: &[String]) -> String {
    let mut note = format!("{NOTE} {made}");
    for hash in hashes {
        note.push(' ');
        note.push_str(hash);
    }
    note
}

/// The hashes of the frames of a film with such a note and this stamp.
pub fn hashes(note: &str, made: &str, frames: u64) -> Option<Vec<String>> {
    let rest = note.strip_prefix(NOTE)?.strip_prefix(' ')?.strip_prefix(made)?;
    let hashes: Vec<String> = rest.split_ascii_whitespace().map(str::to_owned).collect();
    (hashes.len() as u64 == frames).then_some(hashes)
}

/// The hash of the film of a frame whose files are all there and carry the stamp.
pub fn finished(files: &[FrameFile], stamp: &str) -> Option<String> {
    let mut hashes = files.iter().map(|file| film_hash(&file.path, file.format, stamp));
    let first = hashes.next()??;
    hashes.all(|hash| hash.as_ref() == Some(&first)).then_some(first)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_are_known_again() {
        let own = ["aa".to_owned(), "bb".to_owned()];
        let text = note("cafe", &own);
        assert_eq!(hashes(&text, "cafe", 2), Some(own.to_vec()));
        assert_eq!(hashes(&text, "cafe", 3), None);
        assert_eq!(hashes(&text, "caff", 2), None);
        assert_eq!(hashes("holiday", "cafe", 0), None);
    }
}
