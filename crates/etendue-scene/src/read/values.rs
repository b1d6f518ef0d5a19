//! Numbers, points and colours with their ranges.

use super::fields::Item;
use crate::value::Data;
use etendue::{math::DVec3, spectrum::Spectrum};
use glam::dvec3;
use std::fmt;

/// Coordinates and lengths reach this far, metres, so that squares of them stay finite in `f32`.
pub const FARTHEST: f64 = 1e15;
/// Largest component of a colour.
pub const BRIGHTEST: f64 = 1e30;

/// A range of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lowest.
    pub low: f64,
    /// Without `low` itself.
    pub low_open: bool,
    /// Highest.
    pub high: f64,
    /// Without `high` itself.
    pub high_open: bool,
}

impl Bounds {
    /// Coordinates.
    pub const COORDINATE: Self = Self::within(-FARTHEST, FARTHEST);
    /// Lengths above 0.
    pub const LENGTH: Self = Self { low_open: true, ..Self::within(0.0, FARTHEST) };
    /// Lengths, or 0.
    pub const LENGTH_OR_ZERO: Self = Self::within(0.0, FARTHEST);
    /// Albedos and other fractions.
    pub const UNIT: Self = Self::within(0.0, 1.0);
    /// Radiance and the like.
    pub const LIGHT: Self = Self::within(0.0, BRIGHTEST);

    /// `low..=high`.
    pub const fn within(low: f64, high: f64) -> Self {
        Self { low, low_open: false, high, high_open: false }
    }

    /// Without `low`.
    pub const fn above(self) -> Self {
        Self { low_open: true, ..self }
    }

    /// Without `high`.
    pub const fn below(self) -> Self {
        Self { high_open: true, ..self }
    }

    /// True if it is within.
    pub fn holds(&self, x: f64) -> bool {
        (x > self.low || (x == self.low && !self.low_open)) && (x < self.high || (x == self.high && !self.high_open))
    }
}

impl fmt::Display for Bounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |x: f64| if x.abs() >= 1e7 { format!("{x:e}") } else { format!("{x}") };
        let low = format!("{} {}", if self.low_open { "above" } else { "at least" }, number(self.low));
        let high = format!("{} {}", if self.high_open { "below" } else { "at most" }, number(self.high));
        write!(f, "{low} and {high}")
    }
}

impl<'a> Item<'a> {
    /// A number inside `bounds`; where values may change over time, also by keys.
    pub fn number(&self, bounds: Bounds) -> Option<f64> {
        self.keyed(|item| item.plain_number(bounds))
    }

    /// A number inside `bounds`, written as such.
    pub fn plain_number(&self, bounds: Bounds) -> Option<f64> {
        let x = match self.value.data {
            Data::Integer(x) => x as f64,
            Data::Float(x) => x,
            _ => return self.wrong_kind("a number"),
        };
        if !x.is_finite() {
            return self.error(format!("`{}` is {x}", self.name), "expected a finite number");
        }
        if !bounds.holds(x) {
            return self.error(format!("`{}` is out of range: {x}", self.name), format!("must be {bounds}"));
        }
        Some(x)
    }

    /// A number inside `bounds`, single precision.
    pub fn number_f32(&self, bounds: Bounds) -> Option<f32> {
        let x = self.number(bounds)? as f32;
        if x == 0.0 && bounds.low_open && bounds.low == 0.0 {
            return self.error(format!("`{}` is too close to 0", self.name), format!("must be {bounds}"));
        }
        Some(x)
    }

    /// A whole number in `low..=high`.
    pub fn integer(&self, low: i64, high: i64) -> Option<i64> {
        match self.value.data {
            Data::Integer(x) if (low..=high).contains(&x) => Some(x),
            Data::Integer(x) => {
                self.error(format!("`{}` is out of range: {x}", self.name), format!("must be from {low} to {high}"))
            }
            _ => self.wrong_kind("a whole number"),
        }
    }

    /// A whole number in `low..=high`, of 32 bits.
    pub fn integer_u32(&self, low: u32, high: u32) -> Option<u32> {
        self.integer(low.into(), high.into()).and_then(|x| u32::try_from(x).ok())
    }

    /// `N` numbers inside `bounds`.
    pub fn numbers<const N: usize>(&self, bounds: Bounds) -> Option<[f64; N]> {
        self.fixed(&format!("an array of {N} numbers"), |item| item.plain_number(bounds))
    }

    /// Exactly `N` items, each as `parse` understands it; reports every bad one.
    pub fn fixed<T, const N: usize>(&self, expected: &str, parse: impl Fn(Item<'a>) -> Option<T>) -> Option<[T; N]> {
        let items = self.array(expected)?;
        if items.len() != N {
            let message = format!("`{}` must be {expected}, but has {} items", self.name, items.len());
            return self.error(message, format!("expected {expected}"));
        }
        let parsed: Vec<Option<T>> = items.map(parse).collect();
        let parsed: Option<Vec<T>> = parsed.into_iter().collect();
        parsed?.try_into().ok()
    }

    /// A point or vector, metres; where values may change over time, also by keys.
    pub fn point(&self) -> Option<DVec3> {
        self.keyed(|item| item.plain_point())
    }

    /// A point or vector, metres, written as such.
    pub fn plain_point(&self) -> Option<DVec3> {
        self.numbers(Bounds::COORDINATE).map(DVec3::from_array)
    }

    /// A vector that is not zero; where values may change over time, also by keys.
    pub fn direction(&self) -> Option<DVec3> {
        self.keyed(|item| item.not_zero(item.plain_point()?)).and_then(|v| self.not_zero(v))
    }

    fn not_zero(&self, v: DVec3) -> Option<DVec3> {
        match v.try_normalize() {
            Some(_) => Some(v),
            None => self.error(format!("`{}` is zero", self.name), "expected a direction"),
        }
    }

    /// One number for all axes, or three.
    pub fn per_axis(&self, bounds: Bounds) -> Option<DVec3> {
        match self.value.data {
            Data::Array(_) => self.numbers(bounds).map(DVec3::from_array),
            Data::Integer(_) | Data::Float(_) => self.number(bounds).map(DVec3::splat),
            _ => self.wrong_kind("a number or an array of 3 numbers"),
        }
    }

    /// A colour: a number (grey), three numbers (linear sRGB), or `"#rrggbb"` (sRGB); where values may change over time, also
    /// by keys.
    pub fn colour(&self, bounds: Bounds) -> Option<Spectrum> {
        self.keyed(|item| item.plain_colour(bounds))
    }

    fn plain_colour(&self, bounds: Bounds) -> Option<Spectrum> {
        let rgb = match &self.value.data {
            Data::Array(_) => self.numbers(bounds)?,
            Data::Integer(_) | Data::Float(_) => [self.plain_number(bounds)?; 3],
            Data::String(text) => match parse_hex(text) {
                Some(bytes) => bytes.map(srgb_to_linear),
                None => {
                    let message = format!("`{}` is not a colour: `{text}`", self.name);
                    return self.error(message, "expected `#rrggbb`, a number or [r, g, b]");
                }
            },
            _ => return self.wrong_kind("a colour: a number, [r, g, b] or `#rrggbb`"),
        };
        Some(Spectrum(rgb.map(|c| c as f32)))
    }

    /// An axis: a letter or a direction; unit length.
    pub fn axis(&self) -> Option<DVec3> {
        match &self.value.data {
            Data::String(_) => self.choice(&[("x", DVec3::X), ("y", DVec3::Y), ("z", DVec3::Z)]),
            Data::Array(_) => self.direction().map(DVec3::normalize),
            _ => self.wrong_kind("`x`, `y`, `z` or an array of 3 numbers"),
        }
    }

    /// An affine map: 12 numbers (three rows of four) or 16 (with the row 0 0 0 1), flat or in rows.
    pub fn matrix(&self) -> Option<[f64; 12]> {
        const EXPECTED: &str = "12 or 16 numbers, row by row";
        let mut numbers = Vec::with_capacity(16);
        let mut good = true;
        for item in self.array(EXPECTED)? {
            let row: Vec<Item> = match item.value.data {
                Data::Array(_) => item.array(EXPECTED)?.take(17).collect(),
                _ => vec![item],
            };
            for cell in row {
                match cell.number(Bounds::COORDINATE) {
                    Some(x) => numbers.push(x),
                    None => good = false,
                }
            }
            if !good || numbers.len() > 16 {
                break;
            }
        }
        if !good {
            return None;
        }
        if !matches!(numbers.len(), 12 | 16) {
            return self.error(format!("`{}` must be {EXPECTED}", self.name), format!("expected {EXPECTED}"));
        }
        if numbers.len() == 16 && numbers[12..] != [0.0, 0.0, 0.0, 1.0] {
            return self.error(format!("`{}` is not affine", self.name), "its last row must be 0, 0, 0, 1");
        }
        numbers[..12].try_into().ok()
    }
}

/// `#rrggbb` as bytes.
fn parse_hex(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let number = u32::from_str_radix(digits, 16).ok()?;
    let [_, r, g, b] = number.to_be_bytes();
    Some([r, g, b])
}

/// The sRGB transfer function (IEC 61966-2-1), decoded.
fn srgb_to_linear(byte: u8) -> f64 {
    let c = f64::from(byte) / 255.0;
    if c <= 0.040_45 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90.
pub fn sin_cos_degrees(angle: f64) -> (f64, f64) {
    let quarters = libm::round(angle / 90.0);
    let (sin, cos) = libm::sincos((angle - quarters * 90.0).to_radians());
    match (quarters % 4.0) as i32 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// The rotation by `angle` degrees about the unit vector `axis`, right-handed (Rodrigues), as columns.
pub fn rotation(axis: DVec3, angle: f64) -> [DVec3; 3] {
    let (sin, cos) = sin_cos_degrees(angle);
    let column = |e: DVec3| e * cos + axis.cross(e) * sin + axis * (axis.dot(e) * (1.0 - cos));
    [dvec3(1.0, 0.0, 0.0), dvec3(0.0, 1.0, 0.0), dvec3(0.0, 0.0, 1.0)].map(column)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact() {
        for (angle, expected) in
            [(0.0, (0.0, 1.0)), (90.0, (1.0, 0.0)), (-90.0, (-1.0, 0.0)), (450.0, (1.0, 0.0)), (-180.0, (0.0, -1.0))]
        {
            let (sin, cos) = sin_cos_degrees(angle);
            assert_eq!((sin + 0.0, cos + 0.0), expected, "{angle}");
        }
        let (sin, cos) = sin_cos_degrees(30.0);
        assert!((sin - 0.5).abs() < 1e-15 && (cos - 0.75f64.sqrt()).abs() < 1e-15);
        assert_eq!(rotation(DVec3::Y, 90.0)[2] + DVec3::ZERO, DVec3::X);
    }

    #[test]
    fn hexadecimal_colours() {
        assert_eq!(parse_hex("#ff8000"), Some([255, 128, 0]));
        assert_eq!(parse_hex("#ff800"), None);
        assert_eq!(parse_hex("#+f8000"), None);
        assert_eq!((srgb_to_linear(0), srgb_to_linear(255)), (0.0, 1.0));
        assert!((srgb_to_linear(128) - 0.215_860_5).abs() < 1e-6);
    }
}
