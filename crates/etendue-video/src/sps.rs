//! The sequence parameter set of H.264 (ITU-T Rec. H.264, 7.3.2.1.1): what part of the coded blocks is to be shown.

/// `unit` (a network abstraction layer unit without start code) of a baseline stream that crops nothing, made to cut
/// `2 crop` luma pixels off to the right and below. None if it is of another kind.
pub(crate) fn cropped(unit: &[u8], crop: [u32; 2]) -> Option<Vec<u8>> {
    let payload = without_emulation_prevention(unit.get(1..)?);
    let mut from = Reader { bytes: &payload, at: 0 };
    let mut to = Writer::default();
    let profile = to.bits(from.bits(8)?, 8);
    if !matches!(profile, 66 | 77 | 88) {
        return None;
    }
    to.bits(from.bits(16)?, 16); // constraints, level
    to.number(from.number()?); // id
    to.number(from.number()?); // log2_max_frame_num - 4
    match to.number(from.number()?) {
        0 => _ = to.number(from.number()?),
        2 => (),
        _ => return None,
    }
    to.number(from.number()?); // reference frames
    to.bits(from.bits(1)?, 1); // gaps
    to.number(from.number()?); // width in blocks - 1
    to.number(from.number()?); // height in blocks - 1
    if to.bits(from.bits(1)?, 1) != 1 {
        return None; // fields
    }
    to.bits(from.bits(1)?, 1);
    if from.bits(1)? != 0 {
        return None; // crops already
    }
    if crop == [0, 0] {
        to.bits(0, 1);
    } else {
        to.bits(1, 1);
        for edge in [0, crop[0], 0, crop[1]] {
            to.number(edge);
        }
    }
    let end = payload.len() * 8 - payload.last()?.trailing_zeros() as usize - 1;
    while from.at < end {
        to.bits(from.bits(1)?, 1);
    }
    Some([&unit[..1], &with_emulation_prevention(&to.closed())].concat())
}

/// Without the 3 that follows two zeros (7.4.1.1).
fn without_emulation_prevention(bytes: &[u8]) -> Vec<u8> {
    let mut plain = Vec::with_capacity(bytes.len());
    let mut zeros = 0;
    for &byte in bytes {
        if zeros >= 2 && byte == 3 {
            zeros = 0;
            continue;
        }
        zeros = if byte == 0 { zeros + 1 } else { 0 };
        plain.push(byte);
    }
    plain
}

fn with_emulation_prevention(bytes: &[u8]) -> Vec<u8> {
    let mut guarded = Vec::with_capacity(bytes.len() + 2);
    let mut zeros = 0;
    for &byte in bytes {
        if zeros >= 2 && byte <= 3 {
            guarded.push(3);
            zeros = 0;
        }
        zeros = if byte == 0 { zeros + 1 } else { 0 };
        guarded.push(byte);
    }
    guarded
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn bits(&mut self, count: u32) -> Option<u32> {
        let mut value = 0;
        for _ in 0..count {
            let byte = self.bytes.get(self.at / 8)?;
            value = value << 1 | u32::from(byte >> (7 - self.at % 8) & 1);
            self.at += 1;
        }
        Some(value)
    }

    /// Exp-Golomb, unsigned (9.1).
    fn number(&mut self) -> Option<u32> {
        let mut zeros = 0;
        while self.bits(1)? == 0 {
            zeros += 1;
            if zeros > 16 {
                return None;
            }
        }
        Some((1 << zeros) - 1 + self.bits(zeros)?)
    }
}

#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
    used: u32,
}

impl Writer {
    fn bits(&mut self, value: u32, count: u32) -> u32 {
        for bit in (0..count).rev() {
            if self.used.is_multiple_of(8) {
                self.bytes.push(0);
            }
            if let Some(last) = self.bytes.last_mut() {
                *last |= ((value >> bit & 1) as u8) << (7 - self.used % 8);
            }
            self.used += 1;
        }
        value
    }

    fn number(&mut self, value: u32) -> u32 {
        let length = (value + 1).ilog2();
        self.bits(0, length);
        self.bits(value + 1, length + 1);
        value
    }

    /// With the bit that ends a payload.
    fn closed(mut self) -> Vec<u8> {
        self.bits(1, 1);
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back() {
        let mut writer = Writer::default();
        for n in 0..5000 {
            writer.number(n);
        }
        let bytes = writer.closed();
        let mut reader = Reader { bytes: &bytes, at: 0 };
        for n in 0..5000 {
            assert_eq!(reader.number(), Some(n));
        }
        assert_eq!(reader.bits(1), Some(1));
    }

    #[test]
    fn prevention_is_undone() {
        for bytes in [&[0, 0, 0, 0, 0, 1][..], &[0, 0, 3, 0, 0, 2], &[1, 0, 0, 4], &[0, 0]] {
            let guarded = with_emulation_prevention(bytes);
            assert_eq!(without_emulation_prevention(&guarded), bytes);
            assert!(!guarded.windows(3).any(|w| w[0] == 0 && w[1] == 0 && w[2] < 3), "{guarded:?}");
        }
    }

    #[test]
    fn other_streams_are_refused() {
        assert_eq!(cropped(&[], [0, 0]), None);
        assert_eq!(cropped(&[0x67], [0, 0]), None);
        assert_eq!(cropped(&[0x67, 100, 0, 40, 0xff, 0xff, 0xff, 0xff], [0, 0]), None);
        assert_eq!(cropped(&[0x67, 66, 0, 40, 0, 0, 0, 0], [1, 1]), None);
    }
}
