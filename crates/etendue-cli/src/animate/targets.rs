//! Where frames go.

use super::{
    film::{Film, failure_of},
    pattern::Pattern,
};
use crate::{
    exit::{Exit, Failure},
    labels,
};
use etendue_scene::output::{Format, UnknownEnding, atomic};
use etendue_video::{Encoder, Kind, Settings};
use std::{
    io::{self, BufWriter},
    ops::RangeInclusive,
    path::{Path, PathBuf},
};

/// One of the outputs.
#[derive(Debug)]
enum Target {
    /// A picture a frame.
    Pictures { pattern: Pattern, format: Format },
    /// A film in a file.
    Film(Film),
    /// A film to standard output, as it comes.
    Pipe,
}

/// All outputs.
#[derive(Debug)]
pub struct Targets {
    all: Vec<Target>,
}

/// A file that a frame is written to.
#[derive(Debug, PartialEq)]
pub struct FrameFile {
    /// Where it is.
    pub path: PathBuf,
    /// What it is.
    pub format: Format,
    /// True for a frame of a film: opaque bytes.
    pub is_of_film: bool,
}

impl Targets {
    /// What the names say; without any a film in the working directory with the name of the input. Endings and folders are checked
    /// here, so that no render ends with nowhere to go.
    ///
    /// # Errors
    /// Names that are no output; folders that are not there.
    pub fn plan(asked: &[PathBuf], input: &Path) -> Result<Self, Failure> {
        let mut asked = asked.to_vec();
        if asked.is_empty() {
            let kind = if Kind::Mp4.is_available() { Kind::Mp4 } else { Kind::Gif };
            asked.push(default_name(input, kind)?);
        }
        let all: Vec<Target> = asked.iter().map(|path| Target::of(path)).collect::<Result<_, _>>()?;
        for target in &all {
            target.check_writable()?;
        }
        Ok(Self { all })
    }

    /// True if some format keeps more than colour.
    pub fn keeps_layers(&self) -> bool {
        self.all.iter().any(|target| matches!(target, Target::Pictures { format: Format::Exr, .. }))
    }

    /// True if standard output gets a film.
    pub fn has_pipe(&self) -> bool {
        self.all.iter().any(|target| matches!(target, Target::Pipe))
    }

    /// The films.
    pub fn films(&self) -> impl Iterator<Item = &Film> {
        self.all.iter().filter_map(|target| match target {
            Target::Film(film) => Some(film),
            Target::Pictures { .. } | Target::Pipe => None,
        })
    }

    /// True if an interrupted run can be gone on with.
    pub fn can_resume(&self) -> bool {
        self.check_resume().is_ok()
    }

    /// Refuses to go on with outputs whose frames cannot be told.
    pub fn check_resume(&self) -> Result<(), Failure> {
        let unknown = |what: &str| {
            let message = format!("--resume cannot tell which frames {what} holds");
            Err(Failure::new(Exit::Usage, message).hint("it knows those of films, and of .png and .exr pictures"))
        };
        for target in &self.all {
            match target {
                Target::Pipe => return unknown("a pipe"),
                Target::Pictures { format: format @ (Format::Hdr | Format::Pfm), .. } => {
                    return unknown(&format!("a .{} file", format.ending()));
                }
                Target::Pictures { .. } | Target::Film(_) => {}
            }
        }
        Ok(())
    }

    /// Refuses films that cannot be.
    pub fn check(&self, settings: Settings) -> Result<(), Failure> {
        for target in &self.all {
            let kind = match target {
                Target::Film(film) => film.kind,
                Target::Pipe => Kind::Y4m,
                Target::Pictures { .. } => continue,
            };
            settings.check(kind).map_err(|error| failure_of(&error))?;
        }
        Ok(())
    }

    /// Finds the films that are there already, made of what the stamp says, and leaves them as they are. Returns the hashes of one's frames.
    pub fn leave_whole(&mut self, made: &str, frames: u64) -> Option<Vec<String>> {
        let mut found = None;
        for target in &mut self.all {
            if let Target::Film(film) = target
                && let Some(hashes) = film.made_of(made, frames)
            {
                film.is_whole = true;
                found = Some(hashes);
            }
        }
        found
    }

    /// Makes room for frames.
    pub fn prepare(&self) -> Result<(), Failure> {
        self.films().filter(|film| !film.is_whole).try_for_each(Film::prepare)
    }

    /// The files of a frame.
    pub fn files(&self, frame: u32) -> Vec<FrameFile> {
        let file = |target: &Target| match target {
            Target::Pictures { pattern, format } => {
                Some(FrameFile { path: pattern.name(frame), format: *format, is_of_film: false })
            }
            Target::Film(film) => {
                (!film.is_whole).then(|| FrameFile { path: film.frame(frame), format: Format::Png, is_of_film: true })
            }
            Target::Pipe => None,
        };
        self.all.iter().filter_map(file).collect()
    }

    /// What the names of the labels of a frame begin with: they lie beside its picture, or in a folder beside the film. `None` if
    /// there is no file.
    pub fn labels(&self, frame: u32) -> Option<PathBuf> {
        self.all.iter().find_map(|target| match target {
            Target::Pictures { pattern, .. } => Some(labels::stem(&pattern.name(frame))),
            Target::Film(film) => Some(film.labels(frame)),
            Target::Pipe => None,
        })
    }

    /// Makes room for labels, if they can be written.
    pub fn prepare_labels(&self, first: u32) -> Result<(), Failure> {
        match self.all.iter().find(|target| !matches!(target, Target::Pipe)) {
            Some(Target::Film(film)) => film.prepare_labels()?,
            Some(_) => {}
            None => {
                let failure = Failure::new(Exit::Usage, "labels are written beside a file, and there is none");
                return Err(failure.hint("write the film or its pictures to files, too"));
            }
        }
        self.labels(first).map_or(Ok(()), |stem| labels::check_writable(&stem))
    }

    /// Where a frame goes, for people.
    pub fn names(&self, frame: u32) -> Vec<String> {
        let name = |target: &Target| match target {
            Target::Pictures { pattern, .. } => pattern.name(frame).display().to_string(),
            Target::Film(film) => film.path.display().to_string(),
            Target::Pipe => "-".to_owned(),
        };
        self.all.iter().map(name).collect()
    }

    /// The film to standard output, if there is one.
    pub fn pipe(&self, settings: Settings) -> Result<Option<Encoder<'static>>, Failure> {
        let open = || Encoder::stream(BufWriter::new(io::stdout()), Kind::Y4m, settings);
        self.has_pipe().then(open).transpose().map_err(|error| failure_of(&error))
    }

    /// Makes the films of their frames, with a note; `None` if `stopped` said so meanwhile.
    pub fn finish(
        &self,
        frames: RangeInclusive<u32>,
        settings: Settings,
        note: &str,
        stopped: &dyn Fn() -> bool,
    ) -> Result<Option<()>, Failure> {
        for film in self.films().filter(|film| !film.is_whole) {
            if film.finish(frames.clone(), settings, note, stopped)?.is_none() {
                return Ok(None);
            }
        }
        Ok(Some(()))
    }
}

fn default_name(input: &Path, kind: Kind) -> Result<PathBuf, Failure> {
    let gz = input.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gz"));
    let plain = if gz { input.with_extension("") } else { input.to_owned() };
    let mut name = plain
        .file_stem()
        .ok_or_else(|| {
            Failure::new(Exit::Usage, format!("`{}` names no file", input.display())).hint("say where to write with -o")
        })?
        .to_owned();
    name.push(".");
    name.push(kind.extension());
    Ok(name.into())
}

impl Target {
    fn of(path: &Path) -> Result<Self, Failure> {
        if path.as_os_str() == "-" {
            return Ok(Self::Pipe);
        }
        if let Some(pattern) = Pattern::of(path)? {
            return Ok(Self::Pictures { pattern, format: Format::of_path(path)? });
        }
        let ending = path.extension().map(|ending| ending.to_string_lossy().into_owned()).unwrap_or_default();
        if let Some(kind) = Kind::from_extension(&ending) {
            return Ok(Self::Film(Film { path: path.to_owned(), kind, is_whole: false }));
        }
        if Format::of_path(path).is_ok() {
            let message = format!("`{}` is one picture, and there is one for each frame", path.display());
            return Err(Failure::new(Exit::Usage, message).hint(format!("number them: frame.%04d.{ending}")));
        }
        let error = UnknownEnding { path: path.display().to_string() };
        let hint = "write numbered pictures such as frame.%04d.png, or a film: .mp4, .gif, .apng, .y4m";
        Err(Failure::new(Exit::Usage, error).hint(hint))
    }

    fn check_writable(&self) -> Result<(), Failure> {
        match self {
            Self::Pictures { pattern, .. } => Ok(atomic::check_writable(&pattern.name(0))?),
            Self::Film(film) => Ok(atomic::check_writable(&film.path)?),
            Self::Pipe => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_what_they_are() {
        let of = |name: &str| Target::of(Path::new(name));
        assert!(matches!(of("a.%03d.exr"), Ok(Target::Pictures { format: Format::Exr, .. })));
        assert!(matches!(of("a.MP4"), Ok(Target::Film(Film { kind: Kind::Mp4, .. }))));
        assert!(matches!(of("a.png"), Ok(Target::Film(Film { kind: Kind::Apng, .. }))));
        assert!(matches!(of("-"), Ok(Target::Pipe)));
        for bad in ["a.exr", "a.avi", "a", "a.%d.mp4", "a.%d.bmp", "%d"] {
            assert_eq!(of(bad).unwrap_err().exit, Exit::Usage, "{bad}");
        }
    }

    #[test]
    fn default_names() {
        let name = |input: &str| default_name(Path::new(input), Kind::Mp4).unwrap();
        assert_eq!(name("a/b.c.toml"), Path::new("b.c.mp4"));
        assert_eq!(name("b.ply.gz"), Path::new("b.mp4"));
        assert!(default_name(Path::new(".."), Kind::Gif).is_err());
    }
}
