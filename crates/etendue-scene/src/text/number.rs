//! Decimal numbers, correctly rounded.

/// Powers of ten that `f64` holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// Most digits whose value always fits in 64 bits.
const MAX_DIGITS: usize = 19;

/// Powers of ten by which runs of up to eight digits move what comes before them.
const SHIFTS: [u64; 9] = [1, 10, 100, 1000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];

/// Adds a run of digits to `mantissa`; returns the run's end. The value wraps if there are too many digits.
///
/// Eight bytes are looked at as one number (Lemire, "Number parsing at a gigabyte per second", 2021).
#[inline(always)]
pub(crate) fn digits(bytes: &[u8], mut at: usize, mantissa: &mut u64) -> usize {
    while let Some(chunk) = bytes.get(at..).and_then(|rest| rest.first_chunk::<8>()) {
        // Bytes of digits become 0 to 9; of others the top bit is marked, rightly up to the first of them.
        let values = u64::from_le_bytes(*chunk) ^ 0x3030_3030_3030_3030;
        let others = (values.wrapping_add(0x7676_7676_7676_7676) | values) & 0x8080_8080_8080_8080;
        let count = (others.trailing_zeros() / 8) as usize;
        if count == 0 {
            return at;
        }
        // The digits at the end of eight, zeros before them, to the sum of their places.
        let mut sum = values << (64 - 8 * count);
        sum = sum.wrapping_mul(10).wrapping_add(sum >> 8);
        let (even, odd) = (sum & 0x0000_00ff_0000_00ff, (sum >> 16) & 0x0000_00ff_0000_00ff);
        sum = even.wrapping_mul(0x000f_4240_0000_0064).wrapping_add(odd.wrapping_mul(0x0000_2710_0000_0001)) >> 32;
        *mantissa = mantissa.wrapping_mul(SHIFTS[count]).wrapping_add(sum);
        at += count;
        if count < 8 {
            return at;
        }
    }
    digits_at_end(bytes, at, mantissa)
}

/// [`digits`], one at a time.
#[cold]
fn digits_at_end(bytes: &[u8], mut at: usize, mantissa: &mut u64) -> usize {
    while let Some(digit) = bytes.get(at).map(|b| b.wrapping_sub(b'0')).filter(|&d| d < 10) {
        *mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    at
}

/// The decimal number at the start of `bytes`, with its length: `[+-] digits [. digits] [e [+-] digits]`, with a digit
/// before or after the point. The nearest `f64`; infinite if it is too large. `None` if there is no number.
///
/// Up to 2^53 and 22 decimals one division is exact (Clinger, "How to read floating point numbers accurately", 1990);
/// longer numbers go to the standard library.
#[inline]
pub(crate) fn parse(bytes: &[u8]) -> Option<(f64, usize)> {
    let sign = matches!(bytes.first(), Some(b'-' | b'+')) as usize;
    let mut mantissa = 0u64;
    let whole_end = digits(bytes, sign, &mut mantissa);
    let mut end = whole_end;
    let mut decimals = 0;
    if bytes.get(end) == Some(&b'.') {
        end = digits(bytes, whole_end + 1, &mut mantissa);
        decimals = end - whole_end - 1;
    }
    let count = whole_end - sign + decimals;
    if count == 0 {
        return None;
    }
    let mut exponent = -(decimals as i64);
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let negative = bytes.get(end + 1) == Some(&b'-');
        let start = end + 1 + matches!(bytes.get(end + 1), Some(b'-' | b'+')) as usize;
        let mut value = 0u64;
        let exponent_end = digits(bytes, start, &mut value);
        if exponent_end > start {
            // Long exponents wrap: they are left to the standard library.
            let value = if exponent_end - start <= 5 { value as i64 } else { i64::from(i32::MAX) };
            exponent += if negative { -value } else { value };
            end = exponent_end;
        }
    }
    if count > MAX_DIGITS || mantissa > 1 << 53 || exponent.unsigned_abs() > 22 {
        return Some((parse_long(&bytes[..end]), end));
    }
    let power = POWERS[exponent.unsigned_abs() as usize];
    let value = if exponent < 0 { mantissa as f64 / power } else { mantissa as f64 * power };
    Some((if bytes[0] == b'-' { -value } else { value }, end))
}

#[cold]
fn parse_long(number: &[u8]) -> f64 {
    str::from_utf8(number).ok().and_then(|text| text.parse().ok()).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{prelude::*, test_runner::RngSeed};

    /// At the end of the bytes, and with others after it.
    fn check(text: &str) {
        let expected: f64 = text.parse().unwrap();
        for after in ["", " 12345678", "/", ":90000000", "\u{ff}00000000", "\n"] {
            let bytes = [text, after].concat().into_bytes();
            let (value, length) = parse(&bytes).unwrap_or_else(|| panic!("{text}"));
            assert_eq!(value.to_bits(), expected.to_bits(), "{text}");
            assert_eq!(length, text.len(), "{text}");
        }
    }

    #[test]
    fn agrees_with_the_standard_library() {
        for text in [
            "0",
            "-0",
            "+1",
            "1.",
            ".5",
            "-.5e1",
            "1e22",
            "1e23",
            "1e-22",
            "1e-23",
            "9007199254740993",
            "9007199254740992.",
            "123456789012345678901234567890",
            "0.1234567890123456789",
            "1e308",
            "1e309",
            "-1e400",
            "1e-400",
            "5e-324",
            "0.000000000000000000000000000001",
            "1e99999",
            "1e-99999",
            "1e123456789012",
            "0e999999",
            "1.7976931348623157e308",
        ] {
            check(text);
        }
    }

    #[test]
    fn stops_where_the_number_ends() {
        assert_eq!(parse(b"1.5/2"), Some((1.5, 3)));
        assert_eq!(parse(b"1e"), Some((1.0, 1)));
        assert_eq!(parse(b"1e+x"), Some((1.0, 1)));
        assert_eq!(parse(b"1.2.3"), Some((1.2, 3)));
        for none in ["", "-", ".", "-.", "e5", "nan", "inf", "+-1", "x1"] {
            assert_eq!(parse(none.as_bytes()), None, "{none}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 20_000, rng_seed: RngSeed::Fixed(3), failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn any_number_is_exact(text in "[+-]?([0-9]{1,25}(\\.[0-9]{0,25})?|\\.[0-9]{1,25})([eE][+-]?[0-9]{1,4})?") {
            check(&text);
        }

        #[test]
        fn printed_numbers_come_back(value in any::<f64>().prop_filter("finite", |v| v.is_finite())) {
            check(&format!("{value:?}"));
            check(&format!("{value:.6}"));
        }
    }
}
