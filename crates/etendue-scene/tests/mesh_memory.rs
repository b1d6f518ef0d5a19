//! The readers' memory is at most a small multiple of the file, whatever it says, and their time linear.
//! One test alone in this program, since the allocator counts all threads.

mod common;

use common::{check, read_obj, read_off, read_ply, read_stl};
use etendue_scene::{
    SourceMap, gzip,
    mesh_file::{self, MeshLimits},
};
use peak_alloc::PeakAlloc;
use std::fmt::Write;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Bytes of memory for a byte of file, beside a constant. The worst are materials, of a line each and more than a kilobyte,
/// whose number has a limit of its own: some ninety.
const FACTOR: usize = 128;
const CONSTANT: usize = 4 << 20;

fn peak(run: impl FnOnce()) -> usize {
    ALLOCATOR.reset_peak_usage();
    let before = ALLOCATOR.current_usage();
    run();
    ALLOCATOR.peak_usage().saturating_sub(before)
}

/// Reads it both ways and compares the memory with the size.
fn measure(name: &str, bytes: &[u8]) {
    let start = std::time::Instant::now();
    let used = peak(|| {
        let library = if name.contains("library") { bytes } else { b"" };
        check(&read_obj(bytes, library));
        check(&read_ply(bytes));
        check(&read_stl(bytes));
        check(&read_off(bytes));
        let _ = gzip::decompress(bytes, bytes.len() as u64 * 16);
    });
    let ratio = used as f64 / bytes.len() as f64;
    println!("{name}: {} bytes, peak {used} ({ratio:.1} a byte), {:.2} s", bytes.len(), start.elapsed().as_secs_f64());
    assert!(used <= FACTOR * bytes.len() + CONSTANT, "{name}: {used} bytes for {}", bytes.len());
}

fn repeated(head: &str, line: impl Fn(usize) -> String) -> Vec<u8> {
    let mut text = head.to_owned();
    let mut i = 0;
    while text.len() < 1 << 20 {
        text += &line(i);
        i += 1;
    }
    text.into_bytes()
}

/// A wavy grid of triangles with a number of vertices along a side, `with` texture coordinates and normals or without.
fn grid(side: usize, with: bool) -> String {
    let mut text = String::new();
    for i in 0..side * side {
        let (x, y) = (i % side, i / side);
        writeln!(text, "v {}.125 {}.25 {}.5", x, (x * y) % 17, y).unwrap();
        if with {
            writeln!(text, "vt 0.{x:06} 0.{y:06}\nvn 0.25 1.5 0.{x:03}").unwrap();
        }
    }
    for i in (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x + 1)) {
        for corners in [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]] {
            let corner = |i: usize| if with { format!("{i}/{i}/{i}") } else { i.to_string() };
            writeln!(text, "f {} {} {}", corner(corners[0]), corner(corners[1]), corner(corners[2])).unwrap();
        }
    }
    text
}

/// A large file is read from disk with at most 2.5 times the memory of its mesh, and what threads beyond two hold in hand.
fn large_files() {
    let threads = std::thread::available_parallelism().map_or(2, std::num::NonZero::get);
    let in_hand = threads.saturating_sub(2).min(16) * (16 << 20);
    let folder = tempfile::tempdir().unwrap();
    for with in [true, false] {
        let path = folder.path().join("grid.obj");
        std::fs::write(&path, grid(if with { 700 } else { 1100 }, with)).unwrap();
        let mut mesh_bytes = 0;
        let used = peak(|| {
            let mut sources = SourceMap::new();
            let limits = MeshLimits::default();
            let id = mesh_file::open(&mut sources, &path, &limits).unwrap();
            assert!(sources.length(id) > 16 << 20);
            let file = mesh_file::read(&mut sources, id, &limits);
            check(&file);
            let mesh = file.unwrap().mesh;
            assert_eq!((mesh.uvs.is_some(), mesh.normals.is_some()), (with, with));
            let attributes = mesh.positions.len() * if with { 20 } else { 0 };
            mesh_bytes = size_of_val(&*mesh.positions) + size_of_val(&*mesh.indices) + attributes;
        });
        println!("from disk: mesh {mesh_bytes}, peak {used} ({:.2})", used as f64 / mesh_bytes as f64);
        assert!(used <= mesh_bytes / 2 * 5 + in_hand, "{used} bytes for a mesh of {mesh_bytes}");
    }
}

/// Places in a large file, found again on disk.
fn places_in_large_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grid.obj");
    let grid = grid(600, true);
    let lines = grid.lines().count();
    for (end, place, message) in [
        ("f 1 2 3\n f 1 1 2 3\n", (2, 4), "note: 1 corner merged with the same corner beside it"),
        ("f 1 2 x\n", (1, 7), "error: `x` is not a corner of a face"),
        ("\nf 1 -999999 3\n", (2, 5), "error: no vertex -999999 in this file"),
    ] {
        std::fs::write(&path, format!("{grid}{end}")).unwrap();
        let mut sources = SourceMap::new();
        let id = mesh_file::open(&mut sources, &path, &MeshLimits::default()).unwrap();
        assert!(sources.length(id) > 16 << 20);
        let found = match mesh_file::read(&mut sources, id, &MeshLimits::default()) {
            Ok(file) => file.notes,
            Err(found) => found,
        };
        let text: Vec<String> = found.iter().map(|diagnostic| diagnostic.one_line(&sources)).collect();
        let expected = format!("grid.obj:{}:{}: {message}", lines + place.0, place.1);
        assert!(text.iter().any(|line| line.contains(&expected)), "{expected}: {text:?}");
    }
}

#[test]
fn memory_is_bounded_by_the_file() {
    large_files();
    places_in_large_files();
    let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let line = |text: &'static str| move |_: usize| text.to_owned();
    for (name, bytes) in [
        ("positions", repeated("", line("v 0 0 0\n"))),
        ("small faces", repeated(quad, line("f 1 2 3\n"))),
        ("smooth faces", repeated(&format!("{quad}s 1\n"), line("f 1 2 3\n"))),
        ("flat faces among normals", repeated(&format!("{quad}vn 0 0 1\nf 1//1 2//1 3//1\n"), line("f 1 2 3\n"))),
        ("one polygon", repeated(&format!("{quad}f"), |i| format!(" {}", i % 4 + 1))),
        ("one polygon of two", repeated(&format!("{quad}f"), |i| format!(" {}", i % 2 + 1))),
        ("a polygon of one", repeated(&format!("{quad}f"), line(" 1"))),
        ("many smoothing groups", repeated(quad, |i| format!("s {i}\nf 1 2 3\n"))),
        ("many groups", repeated(quad, line("g\no\nf 1 2 3\ng a\nf 1 2 3\n"))),
        ("many materials", repeated(quad, |i| format!("usemtl {i:x}\nf 1 2 3\n"))),
        ("spheres", repeated("", line("sphere 1 2 3 4\n"))),
        ("names over many lines", repeated("", line("g a\\\nb\\\n\nf 1 2 3\n"))),
        ("relative and absolute", repeated(quad, line("f 1 -1 2\nf -2 1 2\n"))),
        ("one position, many uvs", repeated(quad, |i| format!("vt {i}\nf 1/-1 2/-1 3\n"))),
        ("material library", repeated("mtllib m.mtl\n", |i| format!("newmtl {i:x}\n"))),
        ("many libraries", repeated("", |i| format!("mtllib {i:x}\n"))),
        ("same library", repeated("", line("mtllib m.mtl\n"))),
        ("names of libraries", repeated("mtllib", |i| format!(" {i:x}.mtl"))),
        ("unknown statements", repeated("", |i| format!("x{i:x}\n"))),
        ("errors", repeated("", line("f x\n"))),
        ("far ahead", repeated("", line("f 9 9 9\n"))),
        ("line ends", repeated("", line("\n"))),
        ("backslashes", repeated("", line("\\\n"))),
        ("digits", repeated("v ", line("1"))),
        ("word", repeated("", line("a"))),
    ] {
        measure(name, &bytes);
    }
    let facet = |x: usize| format!("facet normal 0 0 1 outer loop vertex {x} 0 0 vertex 0 1 0 vertex 0 0 1 endloop\n");
    let binary_stl = |facets: u32, byte: &dyn Fn(usize) -> u8| -> Vec<u8> {
        let head = [&[0; 80][..], &facets.to_le_bytes()].concat();
        head.into_iter().chain((0..50 * facets.min(20_000) as usize).map(byte)).collect()
    };
    for (name, bytes) in [
        ("text facets", repeated("solid\n", facet)),
        ("shortest text facets", repeated("solid\n", line("loop vertex 1 2 3 vertex 3 2 1 vertex 2 3 1 endloop\n"))),
        ("a loop", repeated("solid\nloop\n", line("vertex 1 2 3\n"))),
        ("solids", repeated("", line("solid a\n"))),
        ("facets of many positions", binary_stl(20_000, &|i| (i.wrapping_mul(0x9e37_79b9) >> 8) as u8 & 0x3f)),
        ("far too many facets", binary_stl(u32::MAX, &|_| 0)),
        ("off vertices", repeated("OFF\n170000 0 0\n", line("0 0 0\n"))),
        ("off faces", repeated("OFF\n3 170000 0\n0 0 0\n1 0 0\n0 1 0\n", line("3 0 1 2\n"))),
        ("off faces of nothing", repeated("OFF\n0 500000 0\n", line("0\n"))),
        ("an off polygon", repeated("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n500000 ", |i| format!("{} ", i % 3))),
        ("far too many in off", repeated("OFF\n4000000000 4000000000 0\n", line("0 0 0\n"))),
    ] {
        measure(name, &bytes);
    }
    let header = |format: &str, rest: &str| format!("ply\nformat {format} 1.0\n{rest}end_header\n");
    let xyz = "property char x\nproperty char y\nproperty char z\n";
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for count in [u64::MAX, u64::from(u32::MAX), 1 << 40, 1 << 31, 1 << 20] {
            for (name, rest) in [
                ("vertices", format!("element vertex {count}\n{xyz}")),
                ("faces", format!("element face {count}\nproperty list uchar uchar vertex_indices\n")),
                ("others", format!("element other {count}\nproperty list uchar double a\nproperty int b\n")),
                ("nothing", format!("element vertex {count}\nelement face {count}\nelement other {count}\n")),
                ("lists", "element other 2\nproperty list uint double a\n".to_owned()),
            ] {
                let mut bytes = header(format, &rest).into_bytes();
                bytes.extend([255; 64]);
                measure(&format!("huge count: {format} {name}"), &bytes);
            }
        }
    }
    let size = 1 << 20;
    let binary = |rest: &str, bytes: &[u8]| {
        let mut file = header("binary_little_endian", rest).into_bytes();
        file.extend(bytes.iter().cycle().take(size));
        file
    };
    let list = "property list uchar uchar vertex_indices\n";
    measure("char vertices", &binary(&format!("element vertex {}\n{xyz}", size / 3), &[0]));
    measure("one-byte faces", &binary(&format!("element vertex 0\n{xyz}element face {size}\n{list}"), &[0]));
    let triple = format!("element vertex 3\n{xyz}element face {}\n{list}", size / 4 - 4);
    measure("char triangles", &binary(&triple, &[0, 0, 0, 1, 0, 0, 0, 1, 0, 3, 0, 1, 2, 3, 0, 1, 2]));
    let many = repeated("ply\nformat ascii 1.0\n", |i| format!("element e{i} 0\n"));
    measure("many elements", &many);
    let mut strips = String::new();
    write!(strips, "ply\nformat ascii 1.0\nelement vertex 3\n{xyz}element tristrips 1\n").unwrap();
    write!(strips, "property list uint char vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n{}", 3 * 100_000).unwrap();
    strips += &" 0 1 2".repeat(100_000);
    measure("one strip", strips.as_bytes());
}
