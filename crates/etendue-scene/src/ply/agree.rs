//! The reader of records of one size and the one of one value after another say the same about any file.

use super::{fixed, header, read, read_in_order};
use crate::{FileId, SourceMap, content::View};

/// SplitMix64 (Steele, Lea, Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, most: usize) -> usize {
        (self.next() % most as u64) as usize
    }

    /// True once in so many times.
    fn once_in(&mut self, times: usize) -> bool {
        self.below(times) == 0
    }

    fn of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }
}

struct File {
    bytes: Vec<u8>,
    big: bool,
}

impl File {
    fn put<const N: usize>(&mut self, mut little: [u8; N]) {
        if self.big {
            little.reverse();
        }
        self.bytes.extend(little);
    }

    fn value(&mut self, kind: &str, value: f64) {
        match kind {
            "char" => self.put((value as i8).to_le_bytes()),
            "uchar" => self.put((value as u8).to_le_bytes()),
            "short" => self.put((value as i16).to_le_bytes()),
            "ushort" => self.put((value as u16).to_le_bytes()),
            "int" => self.put((value as i32).to_le_bytes()),
            "uint" => self.put((value as u32).to_le_bytes()),
            "float" => self.put((value as f32).to_le_bytes()),
            _ => self.put(value.to_le_bytes()),
        }
    }
}

const KINDS: [&str; 8] = ["char", "uchar", "short", "ushort", "int", "uint", "float", "double"];

/// A mesh of which one thing in a few is odd.
fn file(random: &mut Random) -> Vec<u8> {
    let big = random.once_in(2);
    let vertices = random.below(40);
    let faces = random.below(60);
    let mut header = format!("ply\nformat binary_{}_endian 1.0\n", if big { "big" } else { "little" });
    let mut vertex: Vec<(&str, &str)> = vec![];
    let position = if random.once_in(4) { random.of(&KINDS) } else { "float" };
    vertex.extend(["x", "y", "z"].map(|name| (name, position)));
    if random.once_in(3) {
        vertex.extend(["nx", "ny", "nz"].map(|name| (name, "float")));
    }
    if random.once_in(3) {
        let kind = random.of(&["float", "double", "uchar"]);
        vertex.extend(random.of(&[["u", "v"], ["s", "t"]]).map(|name| (name, kind)));
    }
    if random.once_in(3) {
        let kind = random.of(&["uchar", "uchar", "ushort", "float"]);
        vertex.extend(["red", "green", "blue"].map(|name| (name, kind)));
        if random.once_in(2) {
            vertex.push(("alpha", kind));
        }
    }
    if random.once_in(4) {
        vertex.push(("quality", random.of(&KINDS)));
    }
    for i in (1..vertex.len()).rev() {
        vertex.swap(i, random.below(i + 1));
    }
    header += &format!("element vertex {vertices}\n");
    vertex.iter().for_each(|(name, kind)| header += &format!("property {kind} {name}\n"));
    let cameras = if random.once_in(5) { random.below(4) } else { 0 };
    header += &format!("element camera {cameras}\nproperty double where\n");
    let (length, index) =
        (random.of(&["uchar", "uchar", "int", "short"]), random.of(&["int", "int", "uint", "ushort", "uchar"]));
    let (flags, texcoords) = (random.once_in(4), random.once_in(4));
    header += &format!("element face {faces}\n");
    if flags {
        header += "property short flags\n";
    }
    header += &format!("property list {length} {index} vertex_indices\n");
    if texcoords {
        header += "property list uchar float texcoord\n";
    }
    let mut file = File { bytes: (header + "end_header\n").into_bytes(), big };
    let far = if random.once_in(6) { 1e5 } else { 0.0 };
    let (odd, odd_face) = (random.once_in(5), random.once_in(5));
    for _ in 0..vertices {
        for &(name, kind) in &vertex {
            let plain = random.below(2000) as f64 / 1000.0 - 1.0;
            let value = match kind {
                "float" | "double" if odd && random.once_in(40) => {
                    random.of(&[f64::NAN, f64::INFINITY, -0.0, 1e19, 1e18, 3e38])
                }
                "float" | "double" if name.starts_with('n') => {
                    if random.once_in(30) {
                        0.0
                    } else {
                        plain
                    }
                }
                "float" | "double" => plain + far,
                _ => random.below(300) as f64,
            };
            file.value(kind, value);
        }
    }
    (0..cameras).for_each(|_| file.value("double", 1.0));
    for _ in 0..faces {
        if flags {
            file.value("short", 7.0);
        }
        let count = if odd_face && random.once_in(20) { random.below(6) } else { 3 };
        file.value(length, count as f64);
        for _ in 0..count {
            let beyond = if odd_face && random.once_in(60) { 3 } else { 0 };
            let corner = random.below((vertices + beyond).max(1)) as f64 - if beyond > 0 { 1.0 } else { 0.0 };
            file.value(index, corner);
        }
        if texcoords {
            file.value("uchar", 6.0);
            (0..6).for_each(|_| file.value("float", 0.5));
        }
    }
    if random.once_in(8) {
        let length = file.bytes.len();
        file.bytes.truncate(length - random.below(20).min(length / 2));
    } else if random.once_in(8) {
        file.bytes.extend([1, 2, 3]);
    }
    file.bytes
}

fn all(bytes: &[u8], read: impl Fn(&[u8], FileId) -> Result<crate::mesh_file::MeshFile, crate::Diagnostics>) -> String {
    let mut sources = SourceMap::new();
    let file = sources.insert("m.ply", bytes.to_vec()).unwrap();
    format!("{:?}", read(bytes, file))
}

#[test]
fn both_readers_say_the_same() {
    let mut random = Random(1);
    let (mut whole, mut fast) = (0, 0);
    for case in 0..6000 {
        let bytes = file(&mut random);
        let (one, other) = (all(&bytes, read), all(&bytes, read_in_order));
        let header = String::from_utf8_lossy(&bytes).into_owned();
        assert!(one == other, "case {case}: {header:.700}\n{one:.2000}\n{other:.2000}");
        let mut sources = SourceMap::new();
        let id = sources.insert("m.ply", bytes.clone()).unwrap();
        let header = header::parse(&bytes, id).unwrap();
        fast += usize::from(fixed::read(&header, View::Bytes(&bytes), id).unwrap().is_some());
        whole += usize::from(one.starts_with("Ok"));
    }
    assert!(whole > 3000 && fast > 1500, "{whole} files were good, {fast} of records of one size");
}
