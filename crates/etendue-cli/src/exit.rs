//! How the program ends: exit codes, and failures that lead to them.

use etendue_scene::{
    Diagnostics, SourceError,
    image_file::ReadError,
    output::{UnknownEnding, WriteError, metric::CompareError},
};
use std::process::ExitCode;

/// Exit codes of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// All done.
    Done = 0,
    /// The command line is wrong.
    Usage = 1,
    /// A file that was to be read is wrong or missing.
    BadInput = 2,
    /// The input is right but asks for something that is not there yet.
    Unsupported = 3,
    /// A result could not be written.
    CannotWrite = 4,
    /// All was done, but what came out misses the mark that was set.
    Incomplete = 5,
    /// Stopped by a signal; what there was is written.
    Interrupted = 130,
}

impl Exit {
    /// Every code.
    pub const ALL: [Self; 7] = [
        Self::Done,
        Self::Usage,
        Self::BadInput,
        Self::Unsupported,
        Self::CannotWrite,
        Self::Incomplete,
        Self::Interrupted,
    ];

    /// What it says, in one sentence.
    pub fn words(self) -> &'static str {
        match self {
            Self::Done => "Done.",
            Self::Usage => "The command line is wrong.",
            Self::BadInput => "A file that was to be read is wrong or missing.",
            Self::Unsupported => {
                "The input asks for something that is not there yet, such as a file format that is not read."
            }
            Self::CannotWrite => "A result could not be written.",
            Self::Incomplete => {
                "Done, but the result misses the mark that was set, such as diff --fail-above or simplify --require-target."
            }
            Self::Interrupted => "Stopped by a signal. What there was of a picture is written.",
        }
    }

    /// The code for input with errors.
    pub fn of(found: &Diagnostics) -> Self {
        if found.only_unsupported() { Self::Unsupported } else { Self::BadInput }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// What ends the program early.
#[derive(Debug)]
pub struct Failure {
    /// The exit code.
    pub exit: Exit,
    /// What went wrong, for people; empty if it has been said.
    pub message: String,
    /// What to do about it.
    pub hint: Option<String>,
}

impl Failure {
    /// A failure with a message.
    pub fn new(exit: Exit, message: impl ToString) -> Self {
        Self { exit, message: message.to_string(), hint: None }
    }

    /// With what to do about it.
    pub fn hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()), ..self }
    }

    /// A failure that has been reported in full.
    pub fn reported(exit: Exit) -> Self {
        Self { exit, message: String::new(), hint: None }
    }
}

impl From<UnknownEnding> for Failure {
    fn from(error: UnknownEnding) -> Self {
        Self::new(Exit::Usage, error).hint("end the file's name in one of these")
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Self {
        let hint = match &error {
            WriteError::NoFolder { .. } => "make the folder first, or write elsewhere",
            WriteError::NotRegular { .. } => "give the name of a file",
            WriteError::NotWritable { .. } => "change the permissions, or write elsewhere",
            WriteError::DiskFull { .. } => "make room, or write elsewhere",
            WriteError::Encode { .. } => "write a format that holds it",
            WriteError::Io { .. } => "write elsewhere",
        };
        Self::new(Exit::CannotWrite, error).hint(hint)
    }
}

impl From<ReadError> for Failure {
    fn from(error: ReadError) -> Self {
        let hint = match &error {
            ReadError::Io { .. } => LOOK,
            ReadError::UnknownFormat { .. } => "the first bytes of a file tell its format, of TGA the ending .tga",
            ReadError::TooLarge { .. } => "make the picture smaller with another program",
            ReadError::Damaged { .. } => "write it again, or in another format, with the program that it comes from",
        };
        Self::new(Exit::BadInput, error).hint(hint)
    }
}

impl From<SourceError> for Failure {
    fn from(error: SourceError) -> Self {
        let hint = match &error {
            SourceError::NotFound(_) => LOOK,
            SourceError::IsDirectory(_) => "give the name of a file in it",
            SourceError::PermissionDenied(_) => "change its permissions",
            SourceError::TooLarge { .. } => "split the file, or make it smaller",
            _ => "see whether the file can be read at all",
        };
        Self::new(Exit::BadInput, error).hint(hint)
    }
}

impl From<CompareError> for Failure {
    fn from(error: CompareError) -> Self {
        Self::new(Exit::BadInput, error).hint("etendue info tells the size and the channels of a picture")
    }
}

/// What helps where nothing is found.
const LOOK: &str = "check the name, and the folder it is in";
