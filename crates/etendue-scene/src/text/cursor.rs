//! A place in the bytes of a text file that moves forward.

use super::number;
use std::ops::Range;

/// Why there is no number here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NumberError {
    /// The line ends.
    Missing,
    /// Something else than a number.
    Malformed,
    /// Infinite or not a number.
    NotFinite,
}

/// Reads lines and words. Lines end with LF, CRLF or CR; blanks are spaces, tabs, and a backslash at the end of a line with
/// that end. `#` at the start of a word begins a comment, which ends with its line whatever that ends with.
#[derive(Clone, Debug)]
pub(crate) struct Cursor<'a> {
    /// The whole file.
    pub bytes: &'a [u8],
    /// Offset of the next byte, at most the length.
    pub at: usize,
}

impl<'a> Cursor<'a> {
    /// At the start, after a byte order mark.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 } }
    }

    #[inline(always)]
    pub fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    pub fn is_done(&self) -> bool {
        self.at >= self.bytes.len()
    }

    #[inline(always)]
    pub fn skip_blanks(&mut self) {
        loop {
            match self.peek() {
                Some(b' ' | b'\t') => self.at += 1,
                Some(b'\\' | b'\x0b' | b'\x0c') => {
                    if !self.skip_rare_blank() {
                        return;
                    }
                }
                _ => return,
            }
        }
    }

    /// Steps over a continued line's end, a vertical tab or a form feed, if there is one.
    #[cold]
    fn skip_rare_blank(&mut self) -> bool {
        let length = match &self.bytes[self.at..] {
            [b'\\', b'\r', b'\n', ..] => 3,
            [b'\\', b'\r' | b'\n', ..] => 2,
            [b'\\'] | [b'\x0b' | b'\x0c', ..] => 1,
            _ => 0,
        };
        self.at += length;
        length > 0
    }

    /// True at the end of the line or file, or at a comment. To be asked after blanks.
    #[inline(always)]
    pub fn at_line_end(&self) -> bool {
        matches!(self.peek(), None | Some(b'\n' | b'\r' | b'#'))
    }

    /// Moves to the start of the next line, over a continued one.
    #[inline]
    pub fn next_line(&mut self) {
        let comment = self.peek() == Some(b'#');
        loop {
            let end = self.line_end();
            let continued = end > self.at && self.bytes[end - 1] == b'\\' && !comment;
            self.at = end + usize::from(end < self.bytes.len());
            if continued && self.bytes.get(end..end + 2) == Some(b"\r\n") {
                self.at += 1;
            }
            if !continued {
                return;
            }
        }
    }

    /// Offset of the end of this physical line.
    #[inline]
    pub fn line_end(&self) -> usize {
        let rest = &self.bytes[self.at..];
        self.at + rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len())
    }

    /// The next word of this line, empty at its end.
    #[inline]
    pub fn word(&mut self) -> Range<usize> {
        self.skip_blanks();
        let start = self.at;
        if !self.at_line_end() {
            self.at = self.word_end();
        }
        start..self.at
    }

    #[inline]
    fn word_end(&self) -> usize {
        let mut end = self.at;
        while let Some(&byte) = self.bytes.get(end) {
            match byte {
                b' ' | b'\t' | b'\n' | b'\r' | b'\x0b' | b'\x0c' => break,
                b'\\' if matches!(self.bytes.get(end + 1), None | Some(b'\n' | b'\r')) => break,
                _ => end += 1,
            }
        }
        end
    }

    /// What is left of this line, and of those that continue it, without the blanks around it: a name, which may hold blanks
    /// and `#`. [`super::joined`] makes its text.
    pub fn name(&mut self) -> Range<usize> {
        self.skip_blanks();
        let start = self.at;
        let mut end = self.line_end();
        while end > start && self.bytes[end - 1] == b'\\' && end < self.bytes.len() {
            self.at = end + if self.bytes[end..].starts_with(b"\r\n") { 2 } else { 1 };
            end = self.line_end();
        }
        self.at = end;
        let mut name = self.bytes[start..end].trim_ascii_end();
        // Backslashes that only blanks follow, or the end of the file.
        while let Some(rest) = name.strip_suffix(b"\\")
            && matches!(self.bytes.get(start + name.len()), None | Some(b'\n' | b'\r'))
        {
            name = rest.trim_ascii_end();
        }
        start..start + name.len()
    }

    /// The next word as a number. On failure the cursor stands at the word.
    #[inline(always)]
    pub fn number(&mut self) -> Result<f64, NumberError> {
        self.skip_blanks();
        match number::parse(&self.bytes[self.at..]) {
            Some((value, length)) if value.is_finite() && self.ends_word(self.at + length) => {
                self.at += length;
                Ok(value)
            }
            parsed => Err(self.why_not_a_number(parsed.is_some_and(|(value, _)| value.is_infinite()))),
        }
    }

    #[inline(always)]
    fn ends_word(&self, at: usize) -> bool {
        matches!(self.bytes.get(at), None | Some(b' ' | b'\t' | b'\n' | b'\r' | b'\\' | b'\x0b' | b'\x0c'))
    }

    #[cold]
    fn why_not_a_number(&self, infinite: bool) -> NumberError {
        if self.at_line_end() {
            return NumberError::Missing;
        }
        let word = &self.bytes[self.at..self.word_end()];
        let unsigned = word.strip_prefix(b"-").or(word.strip_prefix(b"+")).unwrap_or(word);
        // As C libraries print them: nan, -nan(ind), inf, 1.#QNAN, 1.#INF, -1.#IND.
        let begins = |name: &[u8]| unsigned.len() >= name.len() && unsigned[..name.len()].eq_ignore_ascii_case(name);
        if infinite || begins(b"nan") || begins(b"inf") || begins(b"1.#") {
            NumberError::NotFinite
        } else {
            NumberError::Malformed
        }
    }

    /// The word here, for a message.
    pub fn here(&self) -> Range<usize> {
        self.at..self.word_end().max(self.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_lines() {
        let bytes = b"\xef\xbb\xbfv  1\t2 # c\r\n\nab \\\r\n cd\\\ne #f\rlast\\";
        let mut cursor = Cursor::new(bytes);
        let mut lines = vec![];
        while !cursor.is_done() {
            let mut words = vec![];
            loop {
                let word = cursor.word();
                if word.is_empty() {
                    break;
                }
                words.push(str::from_utf8(&bytes[word]).unwrap());
            }
            cursor.next_line();
            lines.push(words.join("|"));
        }
        assert_eq!(lines, ["v|1|2", "", "", "ab|cd|e", "last"]);
    }

    #[test]
    fn comments_and_continued_lines_are_skipped_whole() {
        let bytes = b"skip \\\r\nthis \\\ntoo\nnext # C:\\\nlast";
        let mut cursor = Cursor::new(bytes);
        cursor.next_line();
        assert_eq!(&bytes[cursor.word()], b"next");
        assert!(cursor.word().is_empty());
        cursor.next_line();
        assert_eq!(&bytes[cursor.word()], b"last");
    }

    #[test]
    fn names_keep_inner_blanks() {
        let bytes = b"usemtl \t Hard #25 White \t\r\nx";
        let mut cursor = Cursor::new(bytes);
        cursor.word();
        assert_eq!(&bytes[cursor.name()], b"Hard #25 White");
        for (text, name, next) in [
            ("a \\\n b \r\nx", "a \\\n b", "x"),
            ("a\\\r\nb\\\rc\nx", "a\\\r\nb\\\rc", "x"),
            ("a \\\n\nx", "a", "x"),
            ("a \\", "a", ""),
            ("\\\nb\nx", "b", "x"),
        ] {
            let mut cursor = Cursor::new(text.as_bytes());
            assert_eq!(&text[cursor.name()], name, "{text:?}");
            // CRLF is the end of a line and an empty line.
            let mut word = 0..0;
            while word.is_empty() && !cursor.is_done() {
                cursor.next_line();
                word = cursor.word();
            }
            assert_eq!(&text[word], next, "{text:?}");
        }
    }

    #[test]
    fn numbers_and_why_not() {
        let number = |text: &str| Cursor::new(text.as_bytes()).number();
        assert_eq!(number(" \t-1.5e1 2"), Ok(-15.0));
        assert_eq!(number("2 #comment"), Ok(2.0));
        assert_eq!(number("  \n1"), Err(NumberError::Missing));
        assert_eq!(number("# 1"), Err(NumberError::Missing));
        for text in ["x", "1,5", "1.2.3", "1e", "--1", "0x10", "1_0"] {
            assert_eq!(number(text), Err(NumberError::Malformed), "{text}");
        }
        for text in ["nan", "-NaN(ind)", "inf", "-Infinity", "1.#QNAN", "-1.#IND", "1e999"] {
            assert_eq!(number(text), Err(NumberError::NotFinite), "{text}");
        }
    }
}
