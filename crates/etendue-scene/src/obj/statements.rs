//! The statements of an OBJ file: its pieces put together.

use super::{
    chunk::{self, Chunk, FACES_A_PLACE, Known, NameAt, Named, Names},
    corners::{Corners, Counts},
    runs::{Faces, Runs},
    skipped::Skipped,
    unifier::NONE,
};
use crate::{
    Diagnostics, FileId,
    content::Content,
    text::{Cursor, Tally, pieces::map_pieces},
    vertex_colors,
};
use glam::DVec3;
use std::{collections::BTreeMap, io, ops::Range};

/// What an OBJ file says. Materials and groups are runs of faces.
pub(super) struct Statements {
    pub positions: Vec<DVec3>,
    /// As in the file, up to the last position that has one.
    pub colors: Vec<[f32; 4]>,
    pub uvs: Vec<[f32; 2]>,
    /// Unit vectors, or zero.
    pub normals: Vec<[f32; 3]>,
    /// The faces, piece by piece.
    pub faces: Vec<PieceFaces>,
    /// Some corner has texture coordinates.
    pub has_uvs: bool,
    /// Some corner has a normal, and some normal has length.
    pub has_normals: bool,
    /// Index into `material_names`, or [`NONE`].
    pub materials: Runs<u32>,
    /// Smoothing groups; 0 is none.
    pub smoothing: Runs<u32>,
    pub groups: Runs<GroupNames>,
    /// The bytes of the names in `groups`.
    pub names: Vec<u8>,
    /// Centre, radius, material.
    pub spheres: Vec<(DVec3, f64, u32)>,
    /// Names that `usemtl` uses, with the place of the first use.
    pub material_names: Vec<Named>,
    /// Names that `mtllib` gives.
    pub libraries: Vec<Named>,
    places: Vec<FacePlaces>,
    pub errors: Diagnostics,
    pub skipped: Tally<Skipped>,
    /// A statement of the format was seen.
    pub is_obj: bool,
}

/// The faces of a piece of the file.
pub(super) struct PieceFaces {
    pub faces: Faces,
    pub corners: Corners,
    /// Positions, texture coordinates and normals before the piece.
    pub base: Counts,
}

/// Where the names of object and group are: bytes of [`Statements::names`].
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct GroupNames {
    pub object: Option<NameAt>,
    pub group: Option<NameAt>,
}

/// Where the faces of a piece stand.
struct FacePlaces {
    /// Number of its first face.
    first: u32,
    /// Its bytes in the file.
    piece: Range<usize>,
    /// Every 1024th face, from the start of the piece.
    places: Vec<usize>,
}

/// Reads the statements of a file in pieces of `size` bytes. Positive indices may run ahead of what they name. If an index
/// names nothing in the end, the file is read again to find all such places.
///
/// # Errors
/// What the disk says.
pub(super) fn parse(content: &Content, size: usize, file: FileId) -> io::Result<Statements> {
    let chunks = map_pieces(content, size, |piece| chunk::parse(piece, file, None))?;
    let (bases, totals) = bases(&chunks);
    if all_indices_name_something(&chunks, &bases, totals) {
        return Ok(Statements::of(chunks, &bases));
    }
    drop(chunks);
    let again = map_pieces(content, size, |piece| {
        let base = bases.get(piece.number).copied().unwrap_or(totals);
        let Chunk { errors, skipped, .. } = chunk::parse(piece, file, Some(Known { base, totals }));
        (errors, skipped)
    })?;
    let mut statements = Statements::of(vec![], &[]);
    for (errors, skipped) in again {
        statements.errors.append(errors);
        statements.skipped.append(skipped);
    }
    Ok(statements)
}

/// The numbers of each kind before each piece, and in all.
fn bases(chunks: &[Chunk]) -> (Vec<Counts>, Counts) {
    let mut sum = [0; 3];
    let bases = chunks.iter().map(|chunk| {
        let counts = chunk.counts();
        let base = sum;
        sum = [0, 1, 2].map(|kind| base[kind] + counts[kind]);
        base
    });
    (bases.collect(), sum)
}

fn all_indices_name_something(chunks: &[Chunk], bases: &[Counts], totals: Counts) -> bool {
    chunks.iter().zip(bases).all(|(chunk, base)| {
        let good =
            |kind: usize| chunk.highest[kind] <= totals[kind] as i64 && base[kind] as i64 + chunk.lowest[kind] >= 0;
        (0..3).all(good)
    })
}

impl Statements {
    fn of(chunks: Vec<Chunk>, bases: &[Counts]) -> Self {
        let mut all = Self {
            positions: vec![],
            colors: vec![],
            uvs: vec![],
            normals: vec![],
            faces: Vec::with_capacity(chunks.len()),
            has_uvs: chunks.iter().any(|chunk| chunk.has_uvs),
            has_normals: chunks.iter().any(|chunk| chunk.has_normals),
            materials: Runs::new(NONE),
            smoothing: Runs::new(0),
            groups: Runs::new(GroupNames { object: None, group: None }),
            names: vec![],
            spheres: vec![],
            material_names: vec![],
            libraries: vec![],
            places: Vec::with_capacity(chunks.len()),
            errors: Diagnostics::new(),
            skipped: Tally::new(),
            is_obj: false,
        };
        all.reserve(&chunks);
        let mut material_ids = BTreeMap::new();
        let mut face = 0;
        for (chunk, base) in chunks.into_iter().zip(bases) {
            let count = chunk.faces.count();
            all.add(chunk, *base, face, &mut material_ids);
            face += count;
        }
        all.has_normals &= all.normals.iter().any(|normal| *normal != [0.0; 3]);
        all
    }

    fn reserve(&mut self, chunks: &[Chunk]) {
        let [positions, uvs, normals] = bases(chunks).1;
        self.positions.reserve_exact(positions);
        self.uvs.reserve_exact(uvs);
        self.normals.reserve_exact(normals);
    }

    /// Appends a piece whose first face is number `face`.
    fn add(&mut self, chunk: Chunk, base: Counts, face: u32, ids: &mut BTreeMap<Vec<u8>, u32>) {
        let Chunk { positions, colors, uvs, normals, corners, faces, material_names, spheres, .. } = chunk;
        if !colors.is_empty() {
            self.colors.resize(self.positions.len(), vertex_colors::NONE);
            self.colors.extend_from_slice(&colors);
        }
        drop(colors);
        self.positions.extend_from_slice(&positions);
        drop(positions);
        self.uvs.extend_from_slice(&uvs);
        drop(uvs);
        self.normals.extend_from_slice(&normals);
        drop(normals);
        let own: Vec<u32> = material_names.into_iter().map(|named| self.material_id(named, ids)).collect();
        let before = self.materials.current;
        let material = |id: Option<u32>| id.map_or(before, |id| own[id as usize]);
        self.materials.append(chunk.materials, face, material);
        self.spheres.extend(spheres.iter().map(|s| (s.center, s.radius, material(s.material))));
        let smoothing = self.smoothing.current;
        self.smoothing.append(chunk.smoothing, face, |group| group.unwrap_or(smoothing));
        let (names, first_name) = (self.groups.current, self.names.len());
        let moved = |name: NameAt| NameAt { start: name.start + first_name, ..name };
        self.groups.append(chunk.groups, face, |Names { object, group }| GroupNames {
            object: object.map_or(names.object, |name| name.map(moved)),
            group: group.map_or(names.group, |name| name.map(moved)),
        });
        self.names.extend_from_slice(&chunk.names);
        self.libraries.extend(chunk.libraries);
        self.places.push(FacePlaces { first: face, piece: chunk.place, places: chunk.face_places });
        self.faces.push(PieceFaces { faces, corners, base });
        self.errors.append(chunk.errors);
        self.skipped.append(chunk.skipped);
        self.is_obj |= chunk.is_obj;
    }

    fn material_id(&mut self, named: Named, ids: &mut BTreeMap<Vec<u8>, u32>) -> u32 {
        if let Some(id) = ids.get(&named.name) {
            return *id;
        }
        let id = self.material_names.len() as u32;
        ids.insert(named.name.clone(), id);
        self.material_names.push(named);
        id
    }

    /// The bytes of a name.
    pub fn name(&self, at: NameAt) -> &[u8] {
        &self.names[at.start..at.start + at.length]
    }

    /// Where a face stands, for a message; the start of its piece if the file cannot be read any more.
    pub fn face_place(&self, content: &Content, face: u32) -> Range<usize> {
        let piece = self.places.partition_point(|places| places.first <= face).saturating_sub(1);
        let Some(FacePlaces { first, piece, places }) = self.places.get(piece) else { return 0..0 };
        let nothing = piece.start..piece.start;
        let mut buffer = Vec::new();
        let Ok(bytes) = content.piece(piece.clone(), &mut buffer) else { return nothing };
        let number = face - first;
        let Some(&at) = places.get((number / FACES_A_PLACE) as usize) else { return nothing };
        let place = place_of_face(Cursor { bytes, at }, number % FACES_A_PLACE);
        piece.start + place.start..piece.start + place.end
    }
}

/// The corners of the face that comes `left` faces after the one whose first corner the cursor is at.
fn place_of_face(mut cursor: Cursor, mut left: u32) -> Range<usize> {
    loop {
        let words = std::iter::from_fn(|| Some(cursor.word()).filter(|word| !word.is_empty()));
        let (count, place) = words.fold((0, None), |(count, place): (u32, Option<Range<usize>>), word| {
            (count + 1, Some(place.map_or(word.start, |place| place.start)..word.end))
        });
        // Faces with fewer corners were skipped.
        if count >= 3 {
            match left.checked_sub(1) {
                Some(rest) => left = rest,
                None => return place.unwrap_or(0..0),
            }
        }
        loop {
            cursor.next_line();
            if cursor.is_done() {
                return cursor.bytes.len()..cursor.bytes.len();
            }
            if &cursor.bytes[cursor.word()] == b"f" {
                break;
            }
        }
    }
}
