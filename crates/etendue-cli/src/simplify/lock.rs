//! Files of vertices that stay.

use etendue_scene::{Diagnostic, Diagnostics, FileId, Span, mesh_file::Numbering};

/// The vertices of the mesh that a lock file names: one index a line, from 0, as the model's file counts; blank lines, and what
/// follows a `#`, do not count.
pub fn read(bytes: &[u8], file: FileId, numbering: &Numbering) -> Result<Vec<u32>, Diagnostics> {
    let mut found = Diagnostics::new();
    let mut numbers = Vec::new();
    let mut start = 0;
    for line in bytes.split_inclusive(|byte| *byte == b'\n') {
        let text = line.split(|byte| *byte == b'#').next().unwrap_or_default();
        let word = text.trim_ascii();
        if !word.is_empty() {
            let at = start + text.len() - text.trim_ascii_start().len();
            match number(word, numbering.count) {
                Ok(number) => numbers.push(number),
                Err(message) => {
                    let label = format!("expected one vertex index a line, {}", range(numbering.count));
                    found.push(Diagnostic::error(message).at(Span::new(file, at..at + word.len())).label(label));
                }
            }
        }
        start += line.len();
    }
    if found.has_errors() { Err(found) } else { Ok(numbering.vertices(&numbers)) }
}

fn number(word: &[u8], count: usize) -> Result<u32, String> {
    let text = String::from_utf8_lossy(word);
    let shown: String = text.chars().take(40).collect();
    match text.parse::<u32>() {
        Ok(number) if (number as usize) < count => Ok(number),
        Ok(number) => Err(format!("there is no vertex {number}: the model has {count}")),
        Err(_) => Err(format!("`{shown}` is no index of a vertex")),
    }
}

fn range(count: usize) -> String {
    if count == 0 { "but the model has none".to_owned() } else { format!("from 0 to {}", count - 1) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_scene::SourceMap;

    fn lines(text: &str, numbering: &Numbering) -> Result<Vec<u32>, Vec<String>> {
        let mut sources = SourceMap::new();
        let file = sources.insert("lock.txt", text.as_bytes().to_vec()).unwrap();
        read(text.as_bytes(), file, numbering).map_err(|found| found.iter().map(|d| d.one_line(&sources)).collect())
    }

    #[test]
    fn one_index_a_line() {
        let same = Numbering::same(6);
        assert_eq!(lines("5\n\n  0 # the tip\r\n# all of it\n3", &same), Ok(vec![0, 3, 5]));
        assert_eq!(lines("", &same), Ok(vec![]));
        // Two vertices of the mesh are number 4 of the file; number 1 is used by no face.
        let numbering = Numbering { count: 6, of_vertices: Some(vec![4, 0, 4, 5]) };
        assert_eq!(lines("4\n1\n", &numbering), Ok(vec![0, 2]));
    }

    #[test]
    fn errors_have_their_place() {
        let found = lines("1\n 6\nx\n-1\n1 2\n99999999999\n", &Numbering::same(6)).unwrap_err();
        for (found, (place, part)) in found.iter().zip([
            ("lock.txt:2:2", "no vertex 6: the model has 6"),
            ("lock.txt:3:1", "`x` is no index"),
            ("lock.txt:4:1", "`-1`"),
            ("lock.txt:5:1", "`1 2`"),
            ("lock.txt:6:1", "`99999999999`"),
        ]) {
            assert!(found.contains(place) && found.contains(part), "{found}");
        }
        assert_eq!(found.len(), 5);
        assert_eq!(lines("0", &Numbering::same(0)).unwrap_err().len(), 1);
    }
}
