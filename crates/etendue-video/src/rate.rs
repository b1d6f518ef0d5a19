use crate::VideoError;
use std::{fmt, str::FromStr};

/// Frames a second, as a reduced fraction: 25, 30000/1001.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FrameRate {
    frames: u32,
    seconds: u32,
}

/// The largest numerator and denominator: 1 MHz, and a frame that stands for eleven days.
const MOST: u64 = 1_000_000;

impl FrameRate {
    /// `frames` in `seconds`, each from 1; reduced, each at most 1 000 000.
    pub fn new(frames: u64, seconds: u64) -> Result<Self, VideoError> {
        let bad = || VideoError::BadRate { given: format!("{frames}/{seconds}") };
        if frames == 0 || seconds == 0 {
            return Err(bad());
        }
        let common = greatest_common_divisor(frames, seconds);
        let part = |n: u64| u32::try_from(n / common).ok().filter(|&n| u64::from(n) <= MOST).ok_or_else(bad);
        Ok(Self { frames: part(frames)?, seconds: part(seconds)? })
    }

    /// Numerator: this many frames ...
    pub const fn frames(self) -> u32 {
        self.frames
    }

    /// Denominator: ... in this many seconds.
    pub const fn seconds(self) -> u32 {
        self.seconds
    }

    /// Frames a second.
    pub fn as_f64(self) -> f64 {
        f64::from(self.frames) / f64::from(self.seconds)
    }

    /// When frame `k` begins, in ticks of which `per_second` make a second, rounded to the nearest. Taking differences of
    /// this spreads the rounding, so that the whole keeps its length.
    pub(crate) fn tick(self, k: u64, per_second: u32) -> u64 {
        let frames = u128::from(self.frames);
        let ticks = (u128::from(k) * u128::from(self.seconds) * u128::from(per_second) * 2 + frames) / (frames * 2);
        u64::try_from(ticks).unwrap_or(u64::MAX)
    }
}

fn greatest_common_divisor(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

impl fmt::Display for FrameRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.seconds {
            1 => write!(f, "{}", self.frames),
            seconds => write!(f, "{}/{seconds}", self.frames),
        }
    }
}

/// `25`, `12.5` (exactly 25/2), `30000/1001`.
impl FromStr for FrameRate {
    type Err = VideoError;

    fn from_str(text: &str) -> Result<Self, VideoError> {
        let bad = || VideoError::BadRate { given: text.to_owned() };
        let whole = |digits: &str| -> Result<u64, VideoError> {
            let plain = !digits.is_empty() && digits.len() <= 12 && digits.bytes().all(|b| b.is_ascii_digit());
            plain.then(|| digits.parse().ok()).flatten().ok_or_else(bad)
        };
        let trimmed = text.trim();
        let (frames, seconds) = if let Some((frames, seconds)) = trimmed.split_once('/') {
            (whole(frames.trim())?, whole(seconds.trim())?)
        } else if let Some((units, decimals)) = trimmed.split_once('.') {
            let decimals = decimals.trim_end_matches('0');
            let scale = u32::try_from(decimals.len()).ok().filter(|&n| n <= 6).map(|n| 10u64.pow(n)).ok_or_else(bad)?;
            let units = if units.is_empty() { 0 } else { whole(units)? };
            let part = if decimals.is_empty() { 0 } else { whole(decimals)? };
            (units.checked_mul(scale).and_then(|n| n.checked_add(part)).ok_or_else(bad)?, scale)
        } else {
            (whole(trimmed)?, 1)
        };
        Self::new(frames, seconds).map_err(|_| bad())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_read_exactly() {
        for (text, expected) in [
            ("25", (25, 1)),
            (" 24 ", (24, 1)),
            ("30000/1001", (30000, 1001)),
            ("50/2", (25, 1)),
            ("12.5", (25, 2)),
            ("29.97", (2997, 100)),
            ("23.976", (2997, 125)),
            ("0.1", (1, 10)),
            (".5", (1, 2)),
            ("25.000", (25, 1)),
        ] {
            let rate: FrameRate = text.parse().unwrap();
            assert_eq!((rate.frames(), rate.seconds()), expected, "{text}");
            assert_eq!(rate.to_string().parse::<FrameRate>().unwrap(), rate);
        }
    }

    #[test]
    fn what_is_no_rate_is_refused() {
        for text in [
            "",
            "0",
            "0/1",
            "1/0",
            "-25",
            "+25",
            "25fps",
            "nan",
            "inf",
            "1e3",
            "25/",
            "/25",
            "1/2/3",
            "0.0",
            ".",
            "1.2.3",
            "99999999999999999999",
            "1000001",
            "1/1000001",
            "0.0000001",
            "٢٥",
        ] {
            assert!(matches!(text.parse::<FrameRate>(), Err(VideoError::BadRate { .. })), "{text}");
        }
    }

    #[test]
    fn ticks_keep_the_length() {
        let rate = FrameRate::new(30, 1).unwrap();
        let delays: Vec<u64> = (0..6).map(|k| rate.tick(k + 1, 100) - rate.tick(k, 100)).collect();
        assert_eq!(delays, [3, 4, 3, 3, 4, 3]);
        assert_eq!(rate.tick(30 * 3600, 100), 3600 * 100);
        let film = FrameRate::new(30000, 1001).unwrap();
        assert_eq!(film.tick(30000, 100), 100_100);
    }
}
