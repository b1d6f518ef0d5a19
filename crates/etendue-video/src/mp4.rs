//! MP4 (ISO/IEC 14496-12, -14 and -15): one track of H.264. The index (`moov`) stands first, so that a browser starts to
//! play before it has everything; it has a known length from the first frame on and is filled in at the end.

use crate::{
    Settings, VideoError,
    encoder::Format,
    h264::{H264, ParameterSets, key_every},
    note,
};
use std::io::{self, Seek, SeekFrom, Write};

/// A writer that can go back.
pub(crate) trait WriteSeek: Write + Seek {}
impl<T: Write + Seek> WriteSeek for T {}

pub(crate) struct Mp4<'w> {
    writer: Box<dyn WriteSeek + 'w>,
    settings: Settings,
    encoder: H264,
    /// Where the film begins in the writer.
    start: u64,
    /// Bytes of each frame.
    sizes: Vec<u32>,
}

impl<'w> Mp4<'w> {
    pub fn new(mut writer: Box<dyn WriteSeek + 'w>, settings: Settings) -> Result<Self, VideoError> {
        let encoder = H264::new(settings)?;
        let start = writer.stream_position()?;
        Ok(Self { writer, settings, encoder, start, sizes: Vec::new() })
    }

    /// All that stands before the first frame. Its length depends on the number of `sizes` alone.
    fn head(&self, sizes: &[u32]) -> Vec<u8> {
        let Some(sets) = self.encoder.parameter_sets() else { return Vec::new() };
        let index = Index { settings: &self.settings, sets, sizes };
        let mut out = Vec::new();
        file_type(&mut out);
        // The places of the frames depend on the length of what stands before them.
        let length = (out.len() + index.written(0).len()) as u64 + DATA_HEADER;
        out.extend_from_slice(&index.written(length));
        let data: u64 = sizes.iter().map(|&n| u64::from(n)).sum();
        out.extend_from_slice(&1u32.to_be_bytes());
        out.extend_from_slice(b"mdat");
        out.extend_from_slice(&(data + DATA_HEADER).to_be_bytes());
        out
    }
}

impl Format for Mp4<'_> {
    fn push(&mut self, rgb: &[u8]) -> Result<(), VideoError> {
        self.encoder.encode(rgb)?;
        if self.sizes.is_empty() {
            let frames = usize::try_from(self.settings.frames).unwrap_or(usize::MAX);
            let blank = self.head(&vec![0; frames]);
            self.writer.write_all(&blank)?;
        }
        let sample = self.encoder.sample();
        self.writer.write_all(sample)?;
        self.sizes.push(u32::try_from(sample.len()).map_err(io::Error::other)?);
        Ok(())
    }

    fn finish(mut self, note: Option<&str>) -> Result<(), VideoError> {
        if let Some(note) = note {
            let mut out = Vec::new();
            boxed(&mut out, b"uuid", |out| {
                out.extend_from_slice(&note::BOX);
                out.extend_from_slice(note.as_bytes());
            });
            self.writer.write_all(&out)?;
        }
        let end = self.writer.stream_position()?;
        let head = self.head(&self.sizes);
        self.writer.seek(SeekFrom::Start(self.start))?;
        self.writer.write_all(&head)?;
        self.writer.seek(SeekFrom::Start(end))?;
        Ok(self.writer.flush()?)
    }
}

/// Length of the header of `mdat`, with a length of 64 bits.
const DATA_HEADER: u64 = 16;

fn file_type(out: &mut Vec<u8>) {
    boxed(out, b"ftyp", |out| {
        out.extend_from_slice(b"isom");
        out.extend_from_slice(&512u32.to_be_bytes());
        out.extend_from_slice(b"isomiso2avc1mp41");
    });
}

struct Index<'a> {
    settings: &'a Settings,
    sets: &'a ParameterSets,
    sizes: &'a [u32],
}

/// A box: its length, its name, what `fill` writes.
fn boxed(out: &mut Vec<u8>, name: &[u8; 4], fill: impl FnOnce(&mut Vec<u8>)) {
    let start = out.len();
    out.extend_from_slice(&[0; 4]);
    out.extend_from_slice(name);
    fill(out);
    let length = (out.len() - start) as u32;
    out[start..start + 4].copy_from_slice(&length.to_be_bytes());
}

/// A box with version and flags.
fn full(out: &mut Vec<u8>, name: &[u8; 4], version: u8, flags: u32, fill: impl FnOnce(&mut Vec<u8>)) {
    boxed(out, name, |out| {
        put(out, [u32::from(version) << 24 | flags]);
        fill(out);
    });
}

fn put<const N: usize>(out: &mut Vec<u8>, words: [u32; N]) {
    for word in words {
        out.extend_from_slice(&word.to_be_bytes());
    }
}

fn put16<const N: usize>(out: &mut Vec<u8>, halves: [u16; N]) {
    for half in halves {
        out.extend_from_slice(&half.to_be_bytes());
    }
}

fn put64(out: &mut Vec<u8>, value: u64) {
    out.extend_from_slice(&value.to_be_bytes());
}

/// Unity, as 3 x 3 fixed-point numbers.
fn put_matrix(out: &mut Vec<u8>) {
    put(out, [0x10000, 0, 0, 0, 0x10000, 0, 0, 0, 0x4000_0000]);
}

impl Index<'_> {
    /// The box `moov`, for data that begin at byte `data` of the film.
    fn written(&self, data: u64) -> Vec<u8> {
        let mut out = Vec::new();
        boxed(&mut out, b"moov", |out| {
            full(out, b"mvhd", 1, 0, |out| {
                self.put_times(out);
                put(out, [0x10000, 0x100_0000, 0, 0]); // speed 1, volume 1
                put_matrix(out);
                put(out, [0, 0, 0, 0, 0, 0, 2]); // the next track's number
            });
            boxed(out, b"trak", |out| self.track(out, data));
        });
        out
    }

    /// Ticks a second and a frame: exact, and fine enough for programs that cut.
    fn ticks(&self) -> [u32; 2] {
        let rate = self.settings.rate;
        let finer = 10_000u32.div_ceil(rate.frames()).min(1_000_000 / rate.seconds()).max(1);
        [rate.frames() * finer, rate.seconds() * finer]
    }

    /// Width and height of what players show: 4:2:0 has even sides, so an odd one shows its last column or row twice. A clean aperture
    /// (12.1.4) could say so, but FFmpeg 9 rounds it down to even and loses a column instead, and all of a picture of one pixel.
    fn shown(&self) -> [u32; 2] {
        self.settings.size.map(|n| n.next_multiple_of(2))
    }

    fn duration(&self) -> u64 {
        self.settings.frames * u64::from(self.ticks()[1])
    }

    /// Created and changed at no known time, for the sake of equal bytes; ticks a second; duration.
    fn put_times(&self, out: &mut Vec<u8>) {
        put64(out, 0);
        put64(out, 0);
        put(out, [self.ticks()[0]]);
        put64(out, self.duration());
    }

    fn track(&self, out: &mut Vec<u8>, data: u64) {
        full(out, b"tkhd", 1, 3, |out| {
            put64(out, 0);
            put64(out, 0);
            put(out, [1, 0]);
            put64(out, self.duration());
            put(out, [0, 0, 0, 0]);
            put_matrix(out);
            put(out, self.shown().map(|n| n << 16));
        });
        boxed(out, b"mdia", |out| {
            full(out, b"mdhd", 1, 0, |out| {
                self.put_times(out);
                put(out, [0x55c4_0000]); // language: undetermined
            });
            full(out, b"hdlr", 0, 0, |out| {
                put(out, [0]);
                out.extend_from_slice(b"vide");
                put(out, [0, 0, 0]);
                out.extend_from_slice(b"VideoHandler\0");
            });
            boxed(out, b"minf", |out| {
                full(out, b"vmhd", 0, 1, |out| put(out, [0, 0]));
                boxed(out, b"dinf", |out| {
                    full(out, b"dref", 0, 0, |out| {
                        put(out, [1]);
                        full(out, b"url ", 0, 1, |_| ()); // in this file
                    });
                });
                boxed(out, b"stbl", |out| self.tables(out, data));
            });
        });
    }

    fn tables(&self, out: &mut Vec<u8>, data: u64) {
        let frames = self.sizes.len() as u32;
        let chunk = u32::try_from(key_every(self.settings)).unwrap_or(u32::MAX).min(frames);
        full(out, b"stsd", 0, 0, |out| {
            put(out, [1]);
            boxed(out, b"avc1", |out| self.sample_entry(out));
        });
        full(out, b"stts", 0, 0, |out| put(out, [1, frames, self.ticks()[1]]));
        full(out, b"stss", 0, 0, |out| {
            put(out, [frames.div_ceil(chunk)]);
            (0..frames).step_by(chunk as usize).for_each(|frame| put(out, [frame + 1]));
        });
        // A chunk is a key frame and what follows it; the last may be shorter.
        let (whole, rest) = (frames / chunk, frames % chunk);
        full(out, b"stsc", 0, 0, |out| {
            put(out, [1 + u32::from(rest > 0), 1, chunk, 1]);
            if rest > 0 {
                put(out, [whole + 1, rest, 1]);
            }
        });
        full(out, b"stsz", 0, 0, |out| {
            put(out, [0, frames]);
            self.sizes.iter().for_each(|&size| put(out, [size]));
        });
        full(out, b"co64", 0, 0, |out| {
            put(out, [frames.div_ceil(chunk)]);
            let mut place = data;
            for sizes in self.sizes.chunks(chunk as usize) {
                put64(out, place);
                place += sizes.iter().map(|&n| u64::from(n)).sum::<u64>();
            }
        });
    }

    fn sample_entry(&self, out: &mut Vec<u8>) {
        put16(out, [0, 0, 0, 1]);
        put(out, [0; 4]);
        put16(out, self.shown().map(|n| n as u16));
        put(out, [0x48_0000, 0x48_0000, 0]); // 72 dots an inch
        put16(out, [1]);
        out.extend_from_slice(&[0; 32]);
        put16(out, [24, 0xffff]);
        boxed(out, b"avcC", |out| {
            let ParameterSets { sequence, picture } = self.sets;
            out.push(1);
            out.extend_from_slice(&sequence[1..4]); // profile, constraints, level
            out.push(0xff); // lengths of four bytes
            out.push(0xe1);
            put16(out, [sequence.len() as u16]);
            out.extend_from_slice(sequence);
            out.push(1);
            put16(out, [picture.len() as u16]);
            out.extend_from_slice(picture);
        });
        boxed(out, b"colr", |out| {
            out.extend_from_slice(b"nclx");
            put16(out, [1, 1, 1]); // BT.709: primaries, transfer, matrix
            out.push(0); // limited range
        });
        boxed(out, b"pasp", |out| put(out, [1, 1]));
    }
}
