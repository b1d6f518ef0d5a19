//! Where frames go.

use super::pattern::Pattern;
use crate::exit::{Exit, Failure};
use etendue_scene::output::{Format, atomic};
use std::path::{Path, PathBuf};

/// One of the outputs.
#[derive(Debug)]
pub enum Target {
    /// A picture a frame.
    Pictures {
        /// Names.
        pattern: Pattern,
        /// Their format.
        format: Format,
    },
}

/// All outputs.
#[derive(Debug)]
pub struct Targets {
    /// In the order given.
    pub all: Vec<Target>,
}

impl Targets {
    /// What the names say. Endings and folders are checked here, so that no render ends with nowhere to go.
    ///
    /// # Errors
    /// Names that are no output; nothing at all; folders that are not there.
    pub fn plan(asked: &[PathBuf], resume: bool) -> Result<Self, Failure> {
        if asked.is_empty() {
            return Err(Failure::new(Exit::Usage, "nowhere to write to").hint("say where with -o frame.%04d.png"));
        }
        let all: Vec<Target> = asked.iter().map(|path| Target::of(path)).collect::<Result<_, _>>()?;
        for (target, path) in all.iter().zip(asked) {
            if resume && !target.keeps_stamp() {
                let message = format!("--resume cannot tell who made `{}`", path.display());
                return Err(Failure::new(Exit::Usage, message).hint("it knows frames by what .png and .exr files hold"));
            }
            target.check_writable()?;
        }
        Ok(Self { all })
    }

    /// True if some format keeps more than colour.
    pub fn keeps_layers(&self) -> bool {
        self.all.iter().any(|target| matches!(target, Target::Pictures { format: Format::Exr, .. }))
    }

    /// The files of a frame.
    pub fn files(&self, frame: u32) -> Vec<(PathBuf, Format)> {
        self.all.iter().map(|target| target.file(frame)).collect()
    }
}

impl Target {
    fn of(path: &Path) -> Result<Self, Failure> {
        match Pattern::of(path)? {
            Some(pattern) => Ok(Self::Pictures { pattern, format: Format::of_path(path)? }),
            None => {
                let message = format!("`{}` has no number for the frames", path.display());
                Err(Failure::new(Exit::Usage, message).hint("such as in frame.%04d.png"))
            }
        }
    }

    fn keeps_stamp(&self) -> bool {
        match self {
            Self::Pictures { format, .. } => matches!(format, Format::Png | Format::Exr),
        }
    }

    fn check_writable(&self) -> Result<(), Failure> {
        match self {
            Self::Pictures { pattern, .. } => Ok(atomic::check_writable(&pattern.name(0))?),
        }
    }

    fn file(&self, frame: u32) -> (PathBuf, Format) {
        match self {
            Self::Pictures { pattern, format } => (pattern.name(frame), *format),
        }
    }
}
