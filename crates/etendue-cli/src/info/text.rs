//! Lines for people: names on the left, values in a column.

use etendue_scene::import::grouped;

/// Text of a file: a title, then rows.
#[derive(Debug, Default)]
pub struct Page(String);

/// Width of the names.
const NAMES: usize = 14;

impl Page {
    /// With a title.
    pub fn new(title: String) -> Self {
        Self(title + "\n")
    }

    /// A name and a value.
    pub fn row(&mut self, name: &str, value: impl AsRef<str>) {
        self.0 += &format!("  {name:NAMES$} {}\n", value.as_ref());
    }

    /// A name and several values below each other; nothing if there are none.
    pub fn rows(&mut self, name: &str, values: impl IntoIterator<Item = String>) {
        let mut name = name;
        for value in values {
            self.row(name, value);
            name = "";
        }
    }

    /// All of it.
    pub fn text(self) -> String {
        self.0
    }
}

/// Bytes, with three digits.
pub fn bytes(count: u64) -> String {
    let units = ["bytes", "kB", "MB", "GB", "TB"];
    let mut size = count as f64;
    let mut unit = 0;
    while size >= 999.5 && unit + 1 < units.len() {
        size /= 1000.0;
        unit += 1;
    }
    match unit {
        0 => format!("{count} bytes"),
        _ if size < 9.995 => format!("{size:.2} {}", units[unit]),
        _ if size < 99.95 => format!("{size:.1} {}", units[unit]),
        _ => format!("{size:.0} {}", units[unit]),
    }
}

/// A count with commas.
pub fn count(number: usize) -> String {
    grouped(number as u64)
}

/// A number with six digits, or fewer if the rest are zeros.
pub fn number(value: f64) -> String {
    let digits = format!("{value:.5e}");
    let size = value.abs();
    match digits.parse::<f64>() {
        Ok(rounded) if value == 0.0 || (1e-4..1e7).contains(&size) => format!("{}", rounded + 0.0),
        _ => digits,
    }
}

/// Three numbers.
pub fn point(value: [f64; 3]) -> String {
    let [x, y, z] = value.map(number);
    format!("[{x}, {y}, {z}]")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_what_tells_something() {
        assert_eq!([0.0, 1.0, -0.5, 123.456789, 12e8].map(number), ["0", "1", "-0.5", "123.457", "1.20000e9"]);
        assert_eq!([12, 1500, 99_960, 2_000_000_000].map(bytes), ["12 bytes", "1.50 kB", "100 kB", "2.00 GB"]);
    }
}
