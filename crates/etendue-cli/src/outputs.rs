//! The picture files of a render: planned before it starts, refreshed while it runs, written at the end.

use crate::{
    exit::{Exit, Failure},
    report,
};
use etendue::image::Image;
use etendue_scene::output::{Encode, Format, Metadata, WriteError, atomic, write_image};
use std::{
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

/// Where pictures go.
#[derive(Debug)]
pub struct Outputs {
    files: Vec<(PathBuf, Format)>,
}

impl Outputs {
    /// The files asked for, or `NAME.png` and `NAME.exr` in the working directory for the input `NAME.toml`, `NAME.obj.gz`. Endings and
    /// folders are checked here, so that no render ends with nowhere to go.
    pub fn plan(asked: &[PathBuf], input: &Path) -> Result<Self, Failure> {
        let mut paths = asked.to_vec();
        if paths.is_empty() {
            let gz = input.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gz"));
            let plain = input.with_extension("");
            let plain = if gz { &plain } else { input };
            let name = plain.file_stem().ok_or_else(|| {
                Failure::new(Exit::Usage, format!("`{}` names no file", input.display()))
                    .hint("say where to write with -o")
            })?;
            paths = [Format::Png, Format::Exr].iter().map(|f| with_ending(name, *f)).collect();
        }
        let mut files: Vec<(PathBuf, Format)> = Vec::new();
        for path in paths {
            let format = Format::of_path(&path)?;
            if !files.iter().any(|(p, _)| *p == path) {
                files.push((path, format));
            }
        }
        for (path, _) in &files {
            atomic::check_writable(path)?;
        }
        Ok(Self { files })
    }

    /// The file names as given.
    pub fn names(&self) -> Vec<String> {
        self.files.iter().map(|(path, _)| path.display().to_string()).collect()
    }

    /// The first file, which names what is written beside the pictures.
    pub fn first(&self) -> &Path {
        self.files.first().map_or(Path::new(""), |(path, _)| path)
    }

    /// True if some format keeps more than colour.
    pub fn keeps_layers(&self) -> bool {
        self.files.iter().any(|(_, format)| *format == Format::Exr)
    }

    /// Writes every file. One that fails does not keep the others from being written; the first failure is returned and the
    /// others are reported.
    pub fn write(&self, image: &Image, metadata: &Metadata, encode: Encode<'_>) -> Result<(), WriteError> {
        let mut first = Ok(());
        for (path, format) in &self.files {
            if let Err(error) = write_image(path, *format, image, metadata, encode) {
                match first {
                    Ok(()) => first = Err(error),
                    Err(_) => report::warning(&error.to_string()),
                }
            }
        }
        first
    }
}

/// Not `with_extension`: the dots in `a.b.toml` are part of the name `a.b`.
fn with_ending(name: &std::ffi::OsStr, format: Format) -> PathBuf {
    let mut name = name.to_owned();
    name.push(".");
    name.push(format.ending());
    name.into()
}

/// Decides when files are refreshed: every few seconds, and seldom enough that writing takes a twentieth of the time.
#[derive(Debug)]
pub struct RefreshClock {
    next: Instant,
}

impl RefreshClock {
    const INTERVAL: Duration = Duration::from_secs(3);

    /// Starts counting.
    pub fn start() -> Self {
        Self { next: Instant::now() + Self::INTERVAL }
    }

    /// True once it is time.
    pub fn is_due(&self) -> bool {
        Instant::now() >= self.next
    }

    /// A refresh took this long.
    pub fn refreshed(&mut self, took: Duration) {
        self.next = Instant::now() + Self::INTERVAL.max(took * 20);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_names_keep_inner_dots() {
        let outputs = Outputs::plan(&[], Path::new("some/where/a.b.toml")).unwrap();
        assert_eq!(outputs.names(), ["a.b.png", "a.b.exr"]);
        assert!(outputs.keeps_layers());
        let outputs = Outputs::plan(&[], Path::new("where/a.b.ply.GZ")).unwrap();
        assert_eq!(outputs.names(), ["a.b.png", "a.b.exr"]);
    }

    #[test]
    fn plans_are_checked() {
        let plan =
            |names: &[&str]| Outputs::plan(&names.iter().map(PathBuf::from).collect::<Vec<_>>(), Path::new("a.toml"));
        assert_eq!(plan(&["a.png", "a.png"]).unwrap().names(), ["a.png"]);
        assert_eq!(plan(&["a.png", "a.gif"]).unwrap_err().exit, Exit::Usage);
        assert_eq!(plan(&["/no/such/folder/a.png"]).unwrap_err().exit, Exit::CannotWrite);
        assert_eq!(Outputs::plan(&[], Path::new("..")).unwrap_err().exit, Exit::Usage);
    }
}
