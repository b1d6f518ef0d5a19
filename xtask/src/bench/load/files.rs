//! Large meshes in files: a wavy grid of triangles in each format.

use std::{
    fs::{self, File},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
};

/// A grid with so many vertices along a side.
#[derive(Clone, Copy)]
struct Grid {
    side: u32,
}

impl Grid {
    fn vertices(self) -> impl Iterator<Item = [f64; 2]> {
        let last = f64::from(self.side - 1);
        (0..self.side).flat_map(move |y| (0..self.side).map(move |x| [f64::from(x) / last, f64::from(y) / last]))
    }

    /// Not on round numbers.
    fn position([u, v]: [f64; 2]) -> [f32; 3] {
        let wave = 0.05 * libm::sin(9.0 * u) + 0.04 * libm::cos(7.0 * v);
        [2.0 * u - 1.0, wave, 2.0 * v - 1.0].map(|x| x as f32)
    }

    fn normal([u, v]: [f64; 2]) -> [f32; 3] {
        let (x, z) = (-0.225 * libm::cos(9.0 * u), 0.14 * libm::sin(7.0 * v));
        let length = (x * x + 1.0 + z * z).sqrt();
        [x / length, 1.0 / length, z / length].map(|x| x as f32)
    }

    fn triangles(self) -> impl Iterator<Item = [u32; 3]> {
        let side = self.side;
        let cells = (0..side - 1).flat_map(move |y| (0..side - 1).map(move |x| y * side + x));
        cells.flat_map(move |a| [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]])
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Order {
    Text,
    Little,
    Big,
}

impl Order {
    fn put<const N: usize>(self, out: &mut impl Write, mut little: [u8; N]) -> io::Result<()> {
        if self == Order::Big {
            little.reverse();
        }
        out.write_all(&little)
    }
}

fn ply(out: &mut impl Write, grid: Grid, order: Order, attributes: bool) -> io::Result<()> {
    let format = match order {
        Order::Text => "ascii",
        Order::Little => "binary_little_endian",
        Order::Big => "binary_big_endian",
    };
    let vertices = grid.vertices().count();
    write!(
        out,
        "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n"
    )?;
    if attributes {
        let floats = ["nx", "ny", "nz", "u", "v"].map(|name| format!("property float {name}\n"));
        let bytes = ["red", "green", "blue"].map(|name| format!("property uchar {name}\n"));
        write!(out, "{}{}", floats.concat(), bytes.concat())?;
    }
    write!(out, "element face {}\nproperty list uchar int vertex_indices\nend_header\n", grid.triangles().count())?;
    for at in grid.vertices() {
        let position = Grid::position(at);
        if order == Order::Text {
            let [x, y, z] = position;
            writeln!(out, "{x:.6} {y:.6} {z:.6}")?;
            continue;
        }
        position.into_iter().try_for_each(|x| order.put(out, x.to_le_bytes()))?;
        if attributes {
            let values = Grid::normal(at).into_iter().chain(at.map(|x| x as f32));
            values.into_iter().try_for_each(|x| order.put(out, x.to_le_bytes()))?;
            out.write_all(&[(at[0] * 255.0) as u8, (at[1] * 255.0) as u8, 77])?;
        }
    }
    for [a, b, c] in grid.triangles() {
        if order == Order::Text {
            writeln!(out, "3 {a} {b} {c}")?;
            continue;
        }
        out.write_all(&[3])?;
        [a, b, c].into_iter().try_for_each(|index| order.put(out, index.to_le_bytes()))?;
    }
    Ok(())
}

fn obj(out: &mut impl Write, grid: Grid, attributes: bool) -> io::Result<()> {
    for at in grid.vertices() {
        let [x, y, z] = Grid::position(at);
        writeln!(out, "v {x:.6} {y:.6} {z:.6}")?;
        if attributes {
            let [x, y, z] = Grid::normal(at);
            writeln!(out, "vt {:.6} {:.6}\nvn {x:.4} {y:.4} {z:.4}", at[0], at[1])?;
        }
    }
    for triangle in grid.triangles() {
        let [a, b, c] = triangle.map(|index| index + 1);
        if attributes {
            writeln!(out, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")?;
        } else {
            writeln!(out, "f {a} {b} {c}")?;
        }
    }
    Ok(())
}

fn stl(out: &mut impl Write, grid: Grid) -> io::Result<()> {
    let positions: Vec<[f32; 3]> = grid.vertices().map(Grid::position).collect();
    out.write_all(&[b' '; 80])?;
    out.write_all(&(grid.triangles().count() as u32).to_le_bytes())?;
    for triangle in grid.triangles() {
        out.write_all(&[0; 12])?;
        for x in triangle.into_iter().flat_map(|index| positions[index as usize]) {
            out.write_all(&x.to_le_bytes())?;
        }
        out.write_all(&[0; 2])?;
    }
    Ok(())
}

/// Makes those files that are not there yet; each an N-th `part` of its usual size.
pub fn make(folder: &Path, part: usize) -> Result<Vec<PathBuf>, String> {
    let at = |path: &Path| format!("{}: ", path.display());
    fs::create_dir_all(folder).map_err(|error| at(folder) + &error.to_string())?;
    // Vertices along a side at full size: ten million triangles of PLY, and about 250 MB of OBJ.
    let sides = [
        ("little.ply", 2237),
        ("big.ply", 2237),
        ("all.ply", 1601),
        ("text.ply", 1001),
        ("binary.stl", 1415),
        ("all.obj", 1090),
        ("plain.obj", 1767),
    ];
    let mut files = vec![];
    for (name, side) in sides {
        let side = ((f64::from(side) / (part as f64).sqrt()) as u32).max(3);
        let path = folder.join(format!("{side}-{name}"));
        if !path.exists() {
            let partial = path.with_extension("part");
            let write = || -> io::Result<()> {
                let mut out = BufWriter::with_capacity(1 << 20, File::create(&partial)?);
                let grid = Grid { side };
                match name {
                    "little.ply" => ply(&mut out, grid, Order::Little, false)?,
                    "big.ply" => ply(&mut out, grid, Order::Big, false)?,
                    "all.ply" => ply(&mut out, grid, Order::Little, true)?,
                    "text.ply" => ply(&mut out, grid, Order::Text, false)?,
                    "all.obj" => obj(&mut out, grid, true)?,
                    "plain.obj" => obj(&mut out, grid, false)?,
                    _ => stl(&mut out, grid)?,
                }
                out.into_inner()?.sync_all()?;
                fs::rename(&partial, &path)
            };
            write().map_err(|error| at(&path) + &error.to_string())?;
        }
        files.push(path);
    }
    Ok(files)
}
