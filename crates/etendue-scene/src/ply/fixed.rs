//! Binary data whose records all have one size, as those of triangle meshes do: read by position in blocks, on several
//! threads, straight into the mesh.
//!
//! Only what needs no message about a place in the data and no repair of vertices is read here. All else is left to the reader
//! of one value after another: lists of several lengths, polygons, indices of nothing, positions that are not finite.

use super::{
    columns::{Columns, VertexArrays},
    elements::{MOST, Reader, Skipped},
    header::{Element, Encoding, Header, Kind, Scalar},
    values::Binary,
};
use crate::{
    FileId,
    content::View,
    indexed::Repair,
    mesh_file::Numbering,
    parallel,
    positions::{Bounds, local_origin},
    text::Tally,
};
use etendue::scene::Mesh;
use etendue_accel::zeroed_shared;
use glam::DVec3;
use std::{
    io,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
};

/// Bytes that a thread reads and decodes at once: they stay in its cache.
const BLOCK: usize = 1 << 18;

/// Bytes of a record that its fields must lie in; longer ones are left to the other reader.
const LONGEST_RECORD: usize = 1 << 12;

/// Where one number stands in a record, and its type.
#[derive(Clone, Copy)]
pub(super) struct Field {
    pub at: usize,
    pub kind: Scalar,
}

impl Field {
    /// Its value; `BIG` is the order of its bytes.
    #[inline(always)]
    pub fn of<const BIG: bool>(self, record: &[u8]) -> f64 {
        let at = self.at;
        match self.kind {
            Scalar::I8 => f64::from(bytes::<1, BIG>(record, at)[0] as i8),
            Scalar::U8 => f64::from(bytes::<1, BIG>(record, at)[0]),
            Scalar::I16 => f64::from(i16::from_le_bytes(bytes::<2, BIG>(record, at))),
            Scalar::U16 => f64::from(u16::from_le_bytes(bytes::<2, BIG>(record, at))),
            Scalar::I32 => f64::from(i32::from_le_bytes(bytes::<4, BIG>(record, at))),
            Scalar::U32 => f64::from(u32::from_le_bytes(bytes::<4, BIG>(record, at))),
            Scalar::F32 => f64::from(f32::from_le_bytes(bytes::<4, BIG>(record, at))),
            Scalar::F64 => f64::from_le_bytes(bytes::<8, BIG>(record, at)),
        }
    }
}

/// `N` bytes, the least significant first.
#[inline(always)]
pub(super) fn bytes<const N: usize, const BIG: bool>(record: &[u8], at: usize) -> [u8; N] {
    let mut bytes = [0; N];
    bytes.copy_from_slice(&record[at..at + N]);
    if BIG {
        bytes.reverse();
    }
    bytes
}

/// Records of one size, one after another.
#[derive(Clone, Copy, Default)]
struct Records {
    start: usize,
    stride: usize,
    count: usize,
}

impl Records {
    /// In one block; at least one.
    fn a_block(self) -> usize {
        (BLOCK / self.stride.max(1)).max(1)
    }

    fn blocks(self) -> usize {
        self.count.div_ceil(self.a_block())
    }

    fn bytes(self, first: usize, count: usize) -> std::ops::Range<usize> {
        self.start + first * self.stride..self.start + (first + count) * self.stride
    }
}

/// How the faces stand in their records.
struct Faces {
    records: Records,
    /// Of each list: where its length stands, and what it has to be.
    lists: Vec<(Field, f64)>,
    /// The first index.
    corner: usize,
    kind: Scalar,
}

/// What is where in a file.
struct Plan {
    vertices: Records,
    columns: Columns,
    faces: Faces,
    /// Bytes after the data.
    trailing: usize,
}

/// What was read, and what a message will be about.
pub(super) struct Fixed {
    pub mesh: Mesh,
    pub numbering: Numbering,
    /// What was skipped or repaired, in the order in which the other reader finds it.
    pub skipped: Tally<Skipped>,
}

/// Why nothing was read.
enum Halt {
    /// It is for the other reader.
    Other,
    Io(io::Error),
}

impl From<io::Error> for Halt {
    fn from(error: io::Error) -> Self {
        Halt::Io(error)
    }
}

/// Reads the data if they are of this kind.
///
/// # Errors
/// What the disk says.
pub(super) fn read(header: &Header, view: View<'_>, file: FileId) -> io::Result<Option<Fixed>> {
    let result = match header.encoding {
        Encoding::Ascii => return Ok(None),
        Encoding::LittleEndian => read_ordered::<false>(header, view, file),
        Encoding::BigEndian => read_ordered::<true>(header, view, file),
    };
    match result {
        Ok(fixed) => Ok(Some(fixed)),
        Err(Halt::Other) => Ok(None),
        Err(Halt::Io(error)) => Err(error),
    }
}

fn read_ordered<const BIG: bool>(header: &Header, view: View<'_>, file: FileId) -> Result<Fixed, Halt> {
    // Only looks at the header.
    let mut reader = Reader::new(header, file, Binary::<BIG> { rest: &[] });
    let plan = plan::<BIG>(&mut reader, view)?;
    let mut skipped = reader.skipped;
    if plan.trailing > 0 {
        skipped.add_many(Skipped::TrailingBytes, b"", plan.trailing, file, 0..0);
    }
    let place = |name: &str| {
        let element = header.elements.iter().find(|element| element.name == name);
        element.map_or(0..0, |element| element.place.clone())
    };
    let (mesh, numbering) = decode::<BIG>(&plan, view, &mut |what, count, element| {
        skipped.add_many(Skipped::Repaired(what), b"", count, file, place(element));
    })?;
    Ok(Fixed { mesh, numbering, skipped })
}

/// Finds every element's place from the header and the first face.
fn plan<const BIG: bool>(reader: &mut Reader<'_, Binary<'_, BIG>>, view: View<'_>) -> Result<Plan, Halt> {
    let mut at = reader.header.data;
    let (mut vertices, mut faces) = (None, None);
    for element in &reader.header.elements {
        let records = |stride: usize| -> Result<Records, Halt> {
            let count = usize::try_from(element.count).map_err(|_| Halt::Other)?;
            let size = stride.checked_mul(count).ok_or(Halt::Other)?;
            let fits = element.count <= MOST && stride <= LONGEST_RECORD && size <= view.len() - at;
            if fits { Ok(Records { start: at, stride, count }) } else { Err(Halt::Other) }
        };
        let records = match element.name.as_str() {
            "vertex" => {
                let records = records(fixed_size(element)?)?;
                let columns = reader.columns(element).map_err(|_| Halt::Other)?;
                vertices = Some((records, Columns::new(element, &columns).ok_or(Halt::Other)?));
                records
            }
            "face" => {
                let indices = reader.face_indices(element).map_err(|_| Halt::Other)?.ok_or(Halt::Other)?;
                let mut shape = face_shape::<BIG>(element, indices, view, at)?;
                shape.records = records(shape.records.stride)?;
                let records = shape.records;
                faces = Some(shape);
                records
            }
            "tristrips" => return Err(Halt::Other),
            _ => {
                reader.note_element(element);
                records(fixed_size(element)?)?
            }
        };
        at += records.stride * records.count;
    }
    match (vertices, faces) {
        (Some((vertices, columns)), Some(faces)) => Ok(Plan { vertices, columns, faces, trailing: view.len() - at }),
        _ => Err(Halt::Other),
    }
}

/// Bytes of an element without lists.
fn fixed_size(element: &Element) -> Result<usize, Halt> {
    element.properties.iter().try_fold(0, |size, property| match property.kind {
        Kind::Scalar(scalar) => Ok(size + scalar.size()),
        Kind::List { .. } => Err(Halt::Other),
    })
}

/// The faces' shape if all are as the first, which has to be a triangle.
fn face_shape<const BIG: bool>(element: &Element, indices: usize, view: View<'_>, at: usize) -> Result<Faces, Halt> {
    let mut buffer = Vec::new();
    let first = view.piece(at..view.len().min(at + LONGEST_RECORD), &mut buffer)?;
    let (mut size, mut lists, mut corner) = (0, vec![], None);
    for (i, property) in element.properties.iter().enumerate() {
        match property.kind {
            Kind::Scalar(scalar) => size += scalar.size(),
            Kind::List { length, item } => {
                let field = Field { at: size, kind: length };
                if size + length.size() > first.len() {
                    return Err(Halt::Other);
                }
                let count = field.of::<BIG>(first);
                if !(0.0..=LONGEST_RECORD as f64).contains(&count) {
                    return Err(Halt::Other);
                }
                size += length.size();
                if i == indices {
                    if count != 3.0 {
                        return Err(Halt::Other);
                    }
                    corner = Some((size, item));
                }
                lists.push((field, count));
                size += item.size() * count as usize;
            }
        }
    }
    let (corner, kind) = corner.ok_or(Halt::Other)?;
    if matches!(kind, Scalar::F32 | Scalar::F64) {
        return Err(Halt::Other);
    }
    Ok(Faces { records: Records { stride: size, ..Records::default() }, lists, corner, kind })
}

/// A run of records and where they go.
enum Job<'a> {
    Vertices { first: usize, arrays: VertexArrays<'a> },
    Faces { first: usize, indices: &'a mut [[u32; 3]] },
}

/// What one thread has, and what it has found.
#[derive(Default)]
struct Seen {
    buffer: Vec<u8>,
    bounds: Bounds,
    zero_normals: usize,
    broken: usize,
}

fn decode<const BIG: bool>(
    plan: &Plan,
    view: View<'_>,
    report: &mut dyn FnMut(Repair, usize, &str),
) -> Result<(Mesh, Numbering), Halt> {
    let Plan { vertices, columns, faces, .. } = plan;
    let mut arrays = columns.allocate(vertices.count);
    let mut indices = zeroed_shared::<[u32; 3]>(faces.records.count);
    let used: Vec<AtomicBool> = (0..vertices.count).map(|_| AtomicBool::new(false)).collect();
    let threads = parallel::threads(vertices.blocks() + faces.records.blocks());
    let vertex_jobs = columns.split(&mut arrays, vertices.a_block());
    let vertex_jobs = vertex_jobs.map(|(first, arrays)| Job::Vertices { first, arrays });
    let a_block = faces.records.a_block();
    let face_jobs = unique(&mut indices).chunks_mut(a_block).enumerate();
    let face_jobs = face_jobs.map(|(block, indices)| Job::Faces { first: block * a_block, indices });
    let seen = parallel::run(threads, vertex_jobs.chain(face_jobs), Seen::default, |seen, job| match job {
        Job::Vertices { first, mut arrays } => {
            let block = view.piece(vertices.bytes(first, arrays.len()), &mut seen.buffer)?;
            let good =
                columns.decode::<BIG>(block, vertices.stride, &mut arrays, &mut seen.bounds, &mut seen.zero_normals);
            if good { Ok(()) } else { Err(Halt::Other) }
        }
        Job::Faces { first, indices } => {
            let block = view.piece(faces.records.bytes(first, indices.len()), &mut seen.buffer)?;
            let broken = faces.decode::<BIG>(block, indices, &used).ok_or(Halt::Other)?;
            seen.broken += broken;
            Ok(())
        }
    })?;
    let mut bounds = Bounds::default();
    seen.iter().for_each(|seen| bounds.add_all(&seen.bounds));
    let zero_normals: usize = seen.iter().map(|seen| seen.zero_normals).sum();
    let broken: usize = seen.iter().map(|seen| seen.broken).sum();
    let unused = used.iter().filter(|used| !used.load(Relaxed)).count();

    if arrays.normals.is_some() && zero_normals > 0 {
        // Without any there are none; some are replaced by the other reader.
        if zero_normals < vertices.count || unused > 0 {
            return Err(Halt::Other);
        }
        arrays.normals = None;
    }
    let mut numbering = Numbering::same(vertices.count);
    if unused > 0 {
        if !columns.positions_are_exact() {
            return Err(Halt::Other);
        }
        report(Repair::Unreferenced, unused, "vertex");
        bounds = arrays.leave_out(&used, unique(&mut indices));
        let is_used = |vertex: &u32| used[*vertex as usize].load(Relaxed);
        numbering.of_vertices = Some((0..vertices.count as u32).filter(is_used).collect());
    }
    if broken > 0 {
        report(Repair::FewCorners, broken, "face");
        indices = indices.iter().copied().filter(is_whole).collect();
    }
    let origin = local_origin(bounds);
    if origin != DVec3::ZERO {
        if !columns.positions_are_exact() {
            return Err(Halt::Other);
        }
        for p in unique(&mut arrays.positions) {
            *p = (DVec3::from(p.map(f64::from)) - origin).as_vec3().to_array();
        }
    }
    columns.finish_colors(&mut arrays);
    let mesh = Mesh {
        origin,
        positions: arrays.positions,
        indices,
        normals: arrays.normals,
        uvs: arrays.uvs,
        colors: arrays.colors,
        face_materials: None,
    };
    Ok((mesh, numbering))
}

/// The values of an array that nothing shares yet.
pub(super) fn unique<T>(array: &mut Arc<[T]>) -> &mut [T] {
    Arc::get_mut(array).unwrap_or_default()
}

/// With three different corners.
fn is_whole([a, b, c]: &[u32; 3]) -> bool {
    a != b && b != c && c != a
}

impl Faces {
    /// Writes the corners of a block of faces and marks the vertices that they use; how many have a corner twice. `None` if
    /// there is a face of another shape or an index of nothing.
    fn decode<const BIG: bool>(&self, block: &[u8], out: &mut [[u32; 3]], used: &[AtomicBool]) -> Option<usize> {
        match self.kind {
            Scalar::I32 | Scalar::U32 => self.decode_with(block, out, used, |record| {
                let corner = |i| u32::from_le_bytes(bytes::<4, BIG>(record, self.corner + i));
                [corner(0), corner(4), corner(8)]
            }),
            kind => self.decode_with(block, out, used, |record| {
                // Below zero is beyond every vertex.
                let corner = |i| Field { at: self.corner + i * kind.size(), kind }.of::<BIG>(record);
                [corner(0) as i32 as u32, corner(1) as i32 as u32, corner(2) as i32 as u32]
            }),
        }
        .filter(|_| self.lists_are_alike::<BIG>(block))
    }

    #[inline(always)]
    fn decode_with(
        &self,
        block: &[u8],
        out: &mut [[u32; 3]],
        used: &[AtomicBool],
        corners: impl Fn(&[u8]) -> [u32; 3],
    ) -> Option<usize> {
        let mut broken = 0;
        for (record, out) in block.chunks_exact(self.records.stride).zip(out) {
            let corners = corners(record);
            for corner in corners {
                used.get(corner as usize)?.store(true, Relaxed);
            }
            broken += usize::from(!is_whole(&corners));
            *out = corners;
        }
        Some(broken)
    }

    fn lists_are_alike<const BIG: bool>(&self, block: &[u8]) -> bool {
        self.lists.iter().all(|&(field, count)| {
            let mut records = block.chunks_exact(self.records.stride);
            if field.kind == Scalar::U8 || field.kind == Scalar::I8 {
                return records.all(|record| record[field.at] == count as u8);
            }
            records.all(|record| field.of::<BIG>(record) == count)
        })
    }
}
