//! One number for a whole picture.

use etendue::image::{ChannelData, Image};
use sha2::{Digest, Sha256};

/// SHA-256, in hexadecimal, of the samples of `image`: channel after channel in the picture's order, each row by row
/// from the top left, each sample as four bytes, little-endian (ids likewise). Names and size do not count. Two renders
/// are the same to the bit if and only if this is equal.
pub fn film_hash(image: &Image) -> String {
    let mut hasher = Sha256::new();
    let mut bytes = Vec::with_capacity(4 * CHUNK);
    for channel in &image.channels {
        match &channel.data {
            ChannelData::F32(data) => update(&mut hasher, &mut bytes, data, |v| v.to_le_bytes()),
            ChannelData::U32(data) => update(&mut hasher, &mut bytes, data, |v| v.to_le_bytes()),
        }
    }
    hex(&hasher.finalize())
}

const CHUNK: usize = 4096;

fn update<T: Copy>(hasher: &mut Sha256, bytes: &mut Vec<u8>, data: &[T], to_bytes: impl Fn(T) -> [u8; 4]) {
    for chunk in data.chunks(CHUNK) {
        bytes.clear();
        bytes.extend(chunk.iter().flat_map(|&v| to_bytes(v)));
        hasher.update(&bytes);
    }
}

fn hex(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    bytes.iter().flat_map(|b| [DIGITS[usize::from(b >> 4)], DIGITS[usize::from(b & 15)]]).map(char::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::image::Channel;

    #[test]
    fn is_sha256_of_the_little_endian_samples() {
        let channel = |name: &str, data| Channel { name: name.to_owned(), data };
        let image = Image {
            width: 1,
            height: 1,
            channels: vec![
                channel("R", ChannelData::F32(vec![1.0])),
                channel("Id", ChannelData::U32(vec![0x0102_0304])),
            ],
        };
        // printf '\x00\x00\x80\x3f\x04\x03\x02\x01' | sha256sum
        assert_eq!(film_hash(&image), "cbb1f7c633ba46f949c7686bac237f60de3363e4ce01d5f9706aa8d802345de1");
    }
}
