//! Pictures as renderers hand them over: PFM (P. Debevec), three floats a pixel.

use std::{fs, path::Path};

/// Linear colours, rows from the bottom as PFM has them.
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f32>,
}

impl Picture {
    /// Reads a file that may be of either byte order.
    pub fn read(path: &Path) -> Result<Self, String> {
        let bytes = fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        Self::parse(&bytes).ok_or_else(|| format!("{}: not a PFM picture of three finite channels", path.display()))
    }

    fn parse(bytes: &[u8]) -> Option<Self> {
        let mut parts = bytes.splitn(4, |&b| b == b'\n');
        let mut line = || std::str::from_utf8(parts.next()?).ok();
        if line()?.trim() != "PF" {
            return None;
        }
        let (width, height) = line()?.trim().split_once(' ')?;
        let (width, height): (usize, usize) = (width.parse().ok()?, height.trim().parse().ok()?);
        let scale: f32 = line()?.trim().parse().ok()?;
        let data = parts.next()?;
        if data.len() != width.checked_mul(height)?.checked_mul(12)? {
            return None;
        }
        let four = |c: &[u8]| [c[0], c[1], c[2], c[3]];
        let float = |c: &[u8]| if scale < 0.0 { f32::from_le_bytes(four(c)) } else { f32::from_be_bytes(four(c)) };
        let values: Vec<f32> = data.chunks_exact(4).map(float).collect();
        values.iter().all(|v| v.is_finite()).then_some(Self { width, height, values })
    }

    /// The mean of pictures of one size.
    pub fn mean(pictures: &[Self]) -> Option<Self> {
        let first = pictures.first()?;
        let mut sums = vec![0.0f64; first.values.len()];
        for picture in pictures {
            sums.iter_mut().zip(&picture.values).for_each(|(sum, &v)| *sum += f64::from(v));
        }
        let values = sums.iter().map(|sum| (sum / pictures.len() as f64) as f32).collect();
        Some(Self { width: first.width, height: first.height, values })
    }
}

#[cfg(test)]
mod tests {
    use super::Picture;

    #[test]
    fn pfm_is_read_and_damage_told() {
        let mut file = b"PF\n2 1\n-1.0\n".to_vec();
        file.extend([1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0].iter().flat_map(|v| v.to_le_bytes()));
        let picture = Picture::parse(&file).unwrap();
        assert_eq!((picture.width, picture.height, picture.values[5]), (2, 1, 6.0));
        assert!(Picture::parse(&file[..file.len() - 1]).is_none());
        let nan = file.len() - 4;
        file[nan..].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(Picture::parse(&file).is_none());
        assert!(Picture::parse(b"PF\n99999999999 99999999999\n-1\n").is_none());
    }
}
