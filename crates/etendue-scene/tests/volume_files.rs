//! NPY and raw volumes, good and bad.
#![allow(clippy::disallowed_methods)]

use etendue::medium::{DensityGrid, Voxels};
use etendue_scene::volume_file::{Axes, ByteOrder, Limits, RawLayout, SampleType, VolumeError, decode_volume, is_npy};
use proptest::prelude::*;
use std::path::Path;

fn npy(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY".to_vec();
    bytes.extend([version, 0]);
    match version {
        1 => bytes.extend((header.len() as u16).to_le_bytes()),
        _ => bytes.extend((header.len() as u32).to_le_bytes()),
    }
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

fn header(descr: &str, fortran: &str, shape: &str) -> String {
    format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}          \n")
}

fn decode(bytes: &[u8]) -> Result<DensityGrid, VolumeError> {
    decode_volume(Path::new("v.npy"), bytes, None, None, &Limits::default())
}

fn values(grid: &DensityGrid) -> Vec<f32> {
    (0..grid.voxels().len()).map(|i| grid.voxels().get(i)).collect()
}

/// `a[i, j, k] = 100 i + 10 j + k`, of shape (2, 3, 4), in one of the orders.
fn counting(fortran: bool) -> Vec<f32> {
    let mut numbers = vec![];
    for at in 0..24 {
        let [i, j, k] = if fortran { [at % 2, at / 2 % 3, at / 6] } else { [at / 12, at / 4 % 3, at % 4] };
        numbers.push((100 * i + 10 * j + k) as f32);
    }
    numbers
}

#[test]
fn shapes_and_orders() {
    for (fortran, word) in [(false, "False"), (true, "True")] {
        let data: Vec<u8> = counting(fortran).iter().flat_map(|v| v.to_le_bytes()).collect();
        for version in [1, 2, 3] {
            let bytes = npy(version, &header("<f4", word, "(2, 3, 4)"), &data);
            assert!(is_npy(&bytes));
            for axes in [None].into_iter().chain(Axes::ALL.map(Some)) {
                let grid = decode_volume(Path::new("v"), &bytes, None, axes, &Limits::default()).unwrap();
                // Which index counts x, y and z.
                let index = ['x', 'y', 'z'].map(|axis| axes.unwrap_or(Axes::XYZ).name().find(axis).unwrap());
                assert_eq!(grid.size(), index.map(|i| [2, 3, 4][i]), "{axes:?}");
                let [nx, ny, _] = grid.size();
                for (at, value) in values(&grid).into_iter().enumerate() {
                    let at = at as u32;
                    let voxel = [at % nx, at / nx % ny, at / nx / ny];
                    let mut indices = [0; 3];
                    (0..3).for_each(|axis| indices[index[axis]] = voxel[axis]);
                    let [i, j, k] = indices;
                    assert_eq!(value, (100 * i + 10 * j + k) as f32, "{axes:?} {voxel:?}");
                }
            }
        }
    }
}

#[test]
fn samples_of_every_type() {
    let of = |descr: &str, data: &[u8]| values(&decode(&npy(1, &header(descr, "False", "(2, 1, 1)"), data)).unwrap());
    // The last digit of a fraction is rounded.
    let near = |found: Vec<f32>, expected: [f32; 2]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-7), "{found:?} {expected:?}");
    };
    near(of("|u1", &[51, 255]), [0.2, 1.0]);
    assert_eq!(of("|b1", &[0, 7]), [0.0, 1.0]);
    near(of("<u2", &[0x33, 0x33, 0xff, 0xff]), [0.2, 1.0]);
    near(of(">u2", &[0, 0, 0x33, 0x33]), [0.0, 0.2]);
    assert_eq!(of("<f2", &[0, 0x3c, 0, 0x40]), [1.0, 2.0]);
    assert_eq!(of(">f2", &[0x3c, 0, 0x40, 0]), [1.0, 2.0]);
    let both = |little: Vec<u8>, kind: &str, size: usize| {
        let big: Vec<u8> = little.chunks(size).flat_map(|c| c.iter().rev().copied()).collect();
        assert_eq!(of(&format!("<{kind}"), &little), [0.25, 3.5]);
        assert_eq!(of(&format!(">{kind}"), &big), [0.25, 3.5]);
    };
    both([0.25f32, 3.5].iter().flat_map(|v| v.to_le_bytes()).collect(), "f4", 4);
    both([0.25f64, 3.5].iter().flat_map(|v| v.to_le_bytes()).collect(), "f8", 8);
    // Half precision stays so in memory.
    let half = decode(&npy(1, &header("<f2", "False", "(2, 1, 1)"), &[0, 0x3c, 0, 0x40])).unwrap();
    assert!(matches!(half.voxels(), Voxels::F16(_)) && half.repaired() == 0);
    let wild: Vec<u8> = [f64::INFINITY, 1e300].iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(decode(&npy(1, &header("<f8", "False", "(2, 1, 1)"), &wild)).unwrap().repaired(), 2);
}

#[test]
fn headers_as_programs_write_them() {
    let good = |header: &str| assert!(decode(&npy(1, header, &[7; 6])).is_ok(), "{header}");
    good("{'descr': '|u1', 'fortran_order': False, 'shape': (1, 2, 3)}");
    good("{\"shape\": (1,2,3,), \"fortran_order\" :True,'descr':\"|u1\"}\n");
    good("  {'shape': (1L, 2L, 3L), 'descr': '|u1', 'fortran_order': False, }  \n");
    good("{'descr': '|u1', 'fortran_order': False, 'shape': (1, 2, 3, 1)}");
    good("{'descr': '|u1', 'fortran_order': False, 'shape': (6, 1, 1, 1, 1)}");
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let says = |bytes: &[u8], part: &str| {
        let error = decode(bytes).unwrap_err().to_string();
        assert!(error.contains(part), "{error}\n{part}");
        assert!(error.starts_with("`v.npy`"), "{error}");
    };
    let with = |text: &str, part: &str| says(&npy(1, text, &[0; 24]), part);
    says(b"", "no NPY file");
    says(b"\x93NUMPY", "at byte 6: the file ends inside of its version");
    says(b"\x93NUMPY\x01\x00\x05", "the file ends inside of the length of its header");
    says(b"\x93NUMPY\x04\x00\x05\x00", "at byte 6: version 4.0 of the format is not known");
    says(b"\x93NUMPY\x02\x00\xff\xff\xff\xff", "at byte 8: a header of 4294967295 bytes");
    says(b"\x93NUMPY\x01\x00\xff\x00{", "the file ends inside of its header");
    with("", "at byte 10: expected `{` in the header, found the end");
    with("{'descr': 3}", "at byte 20: expected a string in the header, found `3`");
    with("{'descr': '<f4", "expected a string that ends");
    with("{'descr': '<f4', 'more': 1}", "at byte 27: unknown key `more`");
    with("{'descr': '<f4', 'fortran_order': Maybe}", "expected True or False");
    with("{'fortran_order': True, 'shape': (1, 2, 3)}", "the header has no `descr`");
    with("{'descr': '<f4', 'fortran_order': True}", "the header has no `shape`");
    with("{'descr': '<f4', 'fortran_order': True, 'shape': (1, -2, 3)}", "expected a whole number of at most 64 bits");
    with(
        "{'descr': '<f4', 'fortran_order': True, 'shape': (1, 99999999999999999999, 3)}",
        "a whole number of at most 64 bits",
    );
    with("{'descr': '<f4', 'fortran_order': True, 'shape': (1, 2 3)}", "expected `)`");
    with("{'descr': '<f4', 'fortran_order': True, 'shape': (1, 2, 3)} x", "expected the end of the header");
    with(&format!("{{'shape': ({})}}", "1,".repeat(65)), "at most 64 dimensions");
    with(&header("[('a', '<f4')]", "False", "(1, 2, 3)").replace("'[", "[").replace("]'", "]"), "expected a string");
    with(&header("<i4", "False", "(1, 2, 3)"), "an array of type `<i4` is no density");
    with(&header("<c8", "False", "(1, 2, 3)"), "is no density");
    with(&header("é", "False", "(1, 2, 3)"), "is no density");
    with(&header("<f4", "False", "(6,)"), "an array of shape (6) is no volume");
    with(&header("<f4", "False", "()"), "an array of shape () is no volume");
    with(&header("<f4", "False", "(1, 2, 3, 2)"), "is no volume");
    with(&header("<f4", "False", "(1, 2, 4)"), "24 bytes of samples, but shape and type make 32");
    with(&header("<f4", "False", "(1, 2, 2)"), "24 bytes of samples, but shape and type make 16");
    with(&header("<f4", "False", "(4294967295, 4294967295, 4294967295)"), "too large");
    with(&header("<f4", "False", "(4294967296, 1, 1)"), "is no volume");
    with(&header("<f4", "False", "(0, 2, 3)"), "24 bytes of samples, but shape and type make 0");
    says(&npy(1, &header("<f4", "False", "(0, 2, 3)"), &[]), "a grid has 1 to 16384 voxels a side, not 0 x 2 x 3");
    says(&npy(1, &header("|u1", "False", "(16385, 1, 1)"), &[0; 16385]), "not 16385 x 1 x 1");
}

#[test]
fn raw_files() {
    let bytes: Vec<u8> = (0..24).collect();
    let mut layout = RawLayout { size: [2, 3, 4], sample: SampleType::U8, byte_order: ByteOrder::Little };
    let read = |layout: &RawLayout, axes, bytes: &[u8]| {
        decode_volume(Path::new("v.raw"), bytes, Some(layout), axes, &Limits::default())
    };
    let grid = read(&layout, None, &bytes).unwrap();
    assert_eq!(grid.size(), [2, 3, 4]);
    assert!(matches!(grid.voxels(), Voxels::U8(voxels) if *voxels == bytes));
    // z runs fastest.
    let grid = read(&layout, Some(Axes::XYZ), &bytes).unwrap();
    assert!(matches!(grid.voxels(), Voxels::U8(voxels) if voxels[..3] == [0, 12, 4]));
    // An NPY file that is described as raw is raw.
    assert!(read(&layout, None, &bytes[..23]).unwrap_err().help().unwrap().contains("`size` and `sample`"));
    layout.sample = SampleType::U16;
    layout.size = [2, 3, 2];
    layout.byte_order = ByteOrder::Big;
    assert!(matches!(read(&layout, None, &bytes).unwrap().voxels(), Voxels::U16(voxels) if voxels[1] == 0x0203));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    /// Damaged files are read or refused; nothing panics, nothing is allocated that the file does not hold.
    #[test]
    fn damaged_files(
        at in 0usize..200,
        bytes in proptest::collection::vec(any::<u8>(), 0..6),
        cut in 0usize..300,
        insert in any::<bool>(),
    ) {
        let data: Vec<u8> = counting(false).iter().flat_map(|v| v.to_le_bytes()).collect();
        let mut file = npy(1, &header("<f4", "False", "(2, 3, 4)"), &data);
        let at = at.min(file.len());
        let end = if insert { at } else { (at + bytes.len()).min(file.len()) };
        file.splice(at..end, bytes);
        file.truncate(file.len().saturating_sub(cut % 7 * 10));
        if let Ok(grid) = decode(&file) {
            prop_assert!(grid.voxels().bytes() <= file.len());
        }
    }

    /// Headers out of pieces of headers.
    #[test]
    fn shuffled_headers(pieces in proptest::collection::vec(0usize..16, 0..24)) {
        const PIECES: [&str; 16] = ["{", "}", "'descr'", "'shape'", "'fortran_order'", ":", ",", "(", ")", "'<f4'", "True", "False",
            "7", " ", "99999999999999999999999", "'"];
        let text: String = pieces.iter().map(|i| PIECES[*i]).collect();
        let _ = decode(&npy(1, &text, &[0; 8]));
        let _ = decode(&npy(3, &text, &[0; 8]));
    }
}
