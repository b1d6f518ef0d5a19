//! What the pages of results share: parts of a page between marks, numbers as they are printed.

use serde_json::Value;
use std::{fs, path::Path};

/// The marks that a part of a page lies between.
fn marks(part: &str) -> [String; 2] {
    [format!("<!-- {part} -->\n"), format!("<!-- end of {part} -->")]
}

/// Writes `content` in place of what a page has as that part.
pub fn put(page: &Path, part: &str, content: &str) -> Result<(), String> {
    let text = fs::read_to_string(page).map_err(|e| format!("{}: {e}", page.display()))?;
    let text = replaced(&text, part, content).ok_or_else(|| {
        let [begin, end] = marks(part);
        format!("{}: {} or {end} is missing", page.display(), begin.trim_end())
    })?;
    super::scenes::write(page, text.as_bytes())
}

fn replaced(text: &str, part: &str, content: &str) -> Option<String> {
    let [begin, end] = marks(part);
    let (before, rest) = text.split_once(&begin)?;
    let (_, after) = rest.split_once(&end)?;
    Some(format!("{before}{begin}{content}{end}{after}"))
}

/// What a benchmark kept under this name, `None` if nothing.
pub fn kept(name: &str) -> Option<Value> {
    let path = super::render::results().join(format!("{name}.json"));
    serde_json::from_slice(&fs::read(path).ok()?).ok()
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

pub fn text(value: &Value) -> &str {
    value.as_str().unwrap_or("")
}

pub fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

/// Three digits.
pub fn three(v: f64) -> String {
    let digits = if v > 0.0 && v.is_finite() { (2 - libm::log10(v).floor() as i32).clamp(0, 6) as usize } else { 0 };
    format!("{v:.digits$}")
}

/// `1.23 (1.1-1.4)` of a value and the ends of its interval.
pub fn with_interval([value, low, high]: [f64; 3]) -> String {
    format!("{} ({}-{})", three(value), three(low), three(high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::root;

    #[test]
    fn only_what_is_between_the_marks_changes() {
        let page = "a\n<!-- x -->\nold\n<!-- end of x -->\nb\n<!-- y -->\n<!-- end of y -->\n";
        let new = "a\n<!-- x -->\nnew\n<!-- end of x -->\nb\n<!-- y -->\n<!-- end of y -->\n";
        assert_eq!(replaced(page, "x", "new\n").as_deref(), Some(new));
        assert_eq!(replaced(page, "z", "new\n"), None);
    }

    #[test]
    fn numbers_have_three_digits() {
        assert_eq!([0.01234, 1.2345, 123.45, 12345.6].map(three), ["0.0123", "1.23", "123", "12346"]);
    }

    #[test]
    fn pages_have_their_marks() {
        let parts = [("performance", &["results", "rays", "builds", "growth"][..]), ("simplify", &["results"])];
        for (name, parts) in parts {
            let page = fs::read_to_string(root().join(format!("docs/{name}.md"))).unwrap();
            for part in parts {
                assert!(marks(part).iter().all(|mark| page.matches(mark).count() == 1), "{name}.md: {part}");
            }
        }
    }
}
