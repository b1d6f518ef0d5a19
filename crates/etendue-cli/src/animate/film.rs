//! Films: frames that wait beside them until they are all there, and the encoding of these.

use super::stamp;
use crate::exit::{Exit, Failure};
use etendue_scene::{
    image_file::{self, Samples, decode_texture},
    output::{EncodeError, atomic},
};
use etendue_video::{Encoder, Kind, Settings, VideoError};
use std::{
    fs,
    io::{self, BufReader, BufWriter},
    path::{Path, PathBuf},
};

/// A film file.
#[derive(Debug)]
pub struct Film {
    /// Where it goes.
    pub path: PathBuf,
    /// Its format.
    pub kind: Kind,
    /// True if it was there before, and stays as it is.
    pub is_whole: bool,
}

impl Film {
    /// The folder of its frames.
    pub fn folder(&self) -> PathBuf {
        self.beside("frames")
    }

    fn beside(&self, what: &str) -> PathBuf {
        let mut name = self.path.file_name().unwrap_or_default().to_owned();
        name.push(".");
        name.push(what);
        self.path.with_file_name(name)
    }

    /// What the names of the labels of a frame begin with.
    pub fn labels(&self, frame: u32) -> PathBuf {
        self.beside("labels").join(format!("frame.{frame:06}"))
    }

    /// Makes the folder of labels.
    pub fn prepare_labels(&self) -> Result<(), Failure> {
        make_folder(&self.beside("labels"))
    }

    /// The file of a frame, a picture without losses.
    pub fn frame(&self, frame: u32) -> PathBuf {
        self.folder().join(format!("frame.{frame:06}.png"))
    }

    /// Makes the folder of frames.
    pub fn prepare(&self) -> Result<(), Failure> {
        make_folder(&self.folder())
    }

    /// The hashes of its frames, if it is there and was made of what the stamp says.
    pub fn made_of(&self, made: &str, frames: u64) -> Option<Vec<String>> {
        let mut file = BufReader::new(fs::File::open(&self.path).ok()?);
        stamp::hashes(&self.kind.note(&mut file).ok()??, made, frames)
    }

    /// Makes the film of its frames, whole or not at all, with a note that says what it is made of, and takes the frames away. `None` if
    /// `stopped` said so meanwhile.
    pub fn finish(
        &self,
        frames: std::ops::RangeInclusive<u32>,
        settings: Settings,
        note: &str,
        stopped: &dyn Fn() -> bool,
    ) -> Result<Option<()>, Failure> {
        // What is not the file system's own failure is told as it is.
        let mut other = None;
        let written = atomic::write(&self.path, |file| {
            let mut film = match Encoder::new(BufWriter::new(file), self.kind, settings) {
                Ok(film) => film,
                Err(error) => return Err(encode_error(error)),
            };
            for frame in frames.clone() {
                let rgb = if stopped() { Err(None) } else { read(&self.frame(frame), settings.size).map_err(Some) };
                match rgb {
                    Ok(rgb) => film.push_rgb8(&rgb).map_err(encode_error)?,
                    Err(failure) => {
                        other = Some(failure);
                        return Err(EncodeError::Malformed("not all frames are there".to_owned()));
                    }
                }
            }
            film.finish_with(note).map_err(encode_error)
        });
        match (written, other) {
            (_, Some(None)) => return Ok(None),
            (_, Some(Some(failure))) => return Err(failure),
            (written, None) => written?,
        }
        self.clean(frames);
        Ok(Some(()))
    }

    /// Takes away the frames, and what a killed run has left of one; a folder that holds anything else stays.
    fn clean(&self, frames: std::ops::RangeInclusive<u32>) {
        let folder = self.folder();
        for frame in frames {
            let _ = fs::remove_file(self.frame(frame));
        }
        for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let name = name.to_string_lossy();
            if name.starts_with(".frame.") && name.ends_with(".part") {
                let _ = fs::remove_file(entry.path());
            }
        }
        let _ = fs::remove_dir(folder);
    }
}

/// Makes a folder for what belongs to frames, if it is not there.
fn make_folder(folder: &Path) -> Result<(), Failure> {
    match fs::create_dir(folder) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists || !folder.is_dir() => {
            let message = format!("cannot make the folder `{}` for frames: {error}", folder.display());
            Err(Failure::new(Exit::CannotWrite, message).hint("write elsewhere"))
        }
        _ => Ok(()),
    }
}

/// The bytes of a frame: red, green, blue.
fn read(path: &Path, [width, height]: [u32; 2]) -> Result<Vec<u8>, Failure> {
    let limits = image_file::Limits::default();
    let lost = |what: String| {
        let message = format!("the frame `{}` {what}", path.display());
        Failure::new(Exit::CannotWrite, message).hint("render it again: the same command with --resume does")
    };
    let bytes = fs::read(path).map_err(|error| lost(format!("cannot be read: {error}")))?;
    let image = decode_texture(path, &bytes, &limits).map_err(|error| lost(format!("is damaged: {error}")))?;
    match image.samples {
        Samples::U8(rgb) if image.channels == 3 && [image.width, image.height] == [width, height] => Ok(rgb),
        _ => Err(lost("is no longer what was written".to_owned())),
    }
}

fn encode_error(error: VideoError) -> EncodeError {
    match error {
        VideoError::Io(error) => EncodeError::Io(error),
        other => EncodeError::Malformed(other.to_string()),
    }
}

/// Why a film cannot be made.
pub fn failure_of(error: &VideoError) -> Failure {
    let (exit, hint) = match error {
        VideoError::LeftOut { .. } => (
            Exit::Unsupported,
            "write .gif, .apng or numbered pictures, or build with a C++ compiler and without --no-default-features",
        ),
        VideoError::TooLarge { .. } => (Exit::Usage, "give a smaller --size, or write numbered pictures"),
        VideoError::TooFast { .. } | VideoError::TooSlow { .. } | VideoError::BadRate { .. } => {
            (Exit::Usage, "give another --fps, or another format")
        }
        VideoError::Io(error) if error.kind() == io::ErrorKind::BrokenPipe => {
            (Exit::CannotWrite, "the program that reads the film has gone away")
        }
        VideoError::Io(_) => (Exit::CannotWrite, "see where standard output is directed to"),
        _ => (Exit::Usage, "etendue animate --help tells what there is"),
    };
    Failure::new(exit, error).hint(hint)
}
