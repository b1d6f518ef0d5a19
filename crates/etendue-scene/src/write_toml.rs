//! Values as a scene file has them.

use glam::DVec3;

/// A string, quoted; reads back as the same text.
pub fn text(value: &str) -> String {
    let mut quoted = String::with_capacity(value.len() + 2);
    quoted.push('"');
    for c in value.chars() {
        match c {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            '\n' => quoted.push_str("\\n"),
            '\t' => quoted.push_str("\\t"),
            '\r' => quoted.push_str("\\r"),
            c if c.is_control() => quoted.push_str(&format!("\\u{:04X}", c as u32)),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

/// A finite number, in as few digits as read back to the same bits.
pub fn number(value: f64) -> String {
    let value = value + 0.0; // no -0
    let size = value.abs();
    if size == 0.0 || (1e-5..1e9).contains(&size) { format!("{value}") } else { format!("{value:e}") }
}

/// An array of numbers.
pub fn numbers(values: impl IntoIterator<Item = f64>) -> String {
    let values: Vec<String> = values.into_iter().map(number).collect();
    format!("[{}]", values.join(", "))
}

/// A point or direction.
pub fn vector(value: DVec3) -> String {
    numbers(value.to_array())
}

/// The nearest number with no more digits than make sense for things of this size: five.
pub fn rounded(value: f64, size: f64) -> f64 {
    let magnitude = libm::floor(libm::log10(size)) as i32 - 4;
    if !(-300..=300).contains(&magnitude) {
        return value;
    }
    // A division by a power of ten is exact to the last bit where a product with its inverse is not.
    let power = libm::pow(10.0, f64::from(magnitude.abs()));
    let rounded = if magnitude < 0 { libm::round(value * power) / power } else { libm::round(value / power) * power };
    if rounded.is_finite() { rounded } else { value }
}

/// [`rounded`], each component.
pub fn rounded_vector(value: DVec3, size: f64) -> DVec3 {
    DVec3::from_array(value.to_array().map(|x| rounded(x, size)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_toml() {
        let words = ["", "a b", "quo\"te \\ \n\t\r\u{1}\u{7f}\u{85} é 猫", "#[x]"];
        for word in words {
            let table: toml::Table = format!("x = {}", text(word)).parse().unwrap();
            assert_eq!(table["x"].as_str(), Some(word));
        }
        for x in [0.0, -0.0, 1.0, -2.5, 1e-7, 1.5e300, 5e-324, 123_456_789.0, 1e9, 0.1, f64::MAX] {
            let table: toml::Table = format!("x = {}", number(x)).parse().unwrap();
            let read = table["x"].as_float().or(table["x"].as_integer().map(|i| i as f64));
            assert_eq!(read, Some(x), "{}", number(x));
        }
        assert_eq!(vector(DVec3::new(1.0, -0.0, 2e-9)), "[1, 0, 2e-9]");
    }

    #[test]
    fn five_digits_of_the_size() {
        assert_eq!(rounded(1.234_567, 2.0), 1.2346);
        assert_eq!(rounded(1_000_000_001.234_567, 2.0), 1_000_000_001.234_6);
        assert_eq!(rounded(1_234_567.0, 2e6), 1_234_600.0);
        assert_eq!(rounded(1.234_567e-6, 2e-6), 1.2346e-6);
        assert_eq!(rounded(0.3, 1e-320), 0.3);
    }
}
