//! Names of numbered pictures.

use crate::exit::{Exit, Failure};
use std::path::{Path, PathBuf};

/// Most digits that numbers are filled up to.
const MOST_DIGITS: usize = 12;

/// A name with a number in it: `frame.%04d.png`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    before: String,
    digits: usize,
    after: String,
}

impl Pattern {
    /// The pattern of a file name; `None` if it has no number. A `%` of the name itself is written `%%`.
    ///
    /// # Errors
    /// Other letters behind a `%`, or more than one number; in the name of the folder none is allowed.
    pub fn of(path: &Path) -> Result<Option<Self>, Failure> {
        let wrong = |what: &str| {
            let message = format!("`{}`: {what}", path.display());
            Failure::new(Exit::Usage, message)
                .hint("write one %d or %04d for the frame's number, and %% for a percent sign")
        };
        let Some(text) = path.to_str() else { return Ok(None) };
        let mut parts = vec![String::new()];
        let mut digits = 0;
        let mut rest = text.chars().peekable();
        while let Some(character) = rest.next() {
            let last = parts.len() - 1;
            if character != '%' {
                parts[last].push(character);
                continue;
            }
            if rest.next_if_eq(&'%').is_some() {
                parts[last].push('%');
                continue;
            }
            let mut count = String::new();
            while let Some(digit) = rest.next_if(char::is_ascii_digit) {
                count.push(digit);
            }
            if rest.next() != Some('d') {
                return Err(wrong("what follows `%` is no number of a frame"));
            }
            digits = match (&count[..], count.parse::<usize>()) {
                ("", _) => 0,
                (_, Ok(count)) if count <= MOST_DIGITS => count,
                _ => return Err(wrong("too many digits")),
            };
            parts.push(String::new());
        }
        match <[String; 2]>::try_from(parts) {
            Ok([before, after]) if after.contains(std::path::is_separator) => {
                let _ = before;
                Err(wrong("the number is in the name of a folder"))
            }
            Ok([before, after]) => Ok(Some(Self { before, digits, after })),
            Err(parts) if parts.len() < 2 => Ok(None),
            Err(_) => Err(wrong("more than one number")),
        }
    }

    /// The name of a frame.
    pub fn name(&self, frame: u32) -> PathBuf {
        PathBuf::from(format!("{}{frame:0width$}{}", self.before, self.after, width = self.digits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Option<Pattern>, Failure> {
        Pattern::of(Path::new(text))
    }

    #[test]
    fn names() {
        let name = |text: &str, frame| of(text).unwrap().unwrap().name(frame).display().to_string();
        assert_eq!(name("frame.%04d.png", 7), "frame.0007.png");
        assert_eq!(name("frame.%04d.png", 123_456), "frame.123456.png");
        assert_eq!(name("a/%d.exr", 0), "a/0.exr");
        assert_eq!(name("100%%_%3d.exr", 5), "100%_005.exr");
        assert_eq!(of("film.mp4").unwrap(), None);
    }

    #[test]
    fn what_is_no_pattern() {
        for bad in ["a%s.png", "a%.png", "%d-%d.png", "a%d/b.png", "a%99d.png", "a%", "%5"] {
            assert_eq!(of(bad).unwrap_err().exit, Exit::Usage, "{bad}");
        }
    }
}
