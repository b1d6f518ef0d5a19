//! What is wrong with a mesh, and what kind of surface it is.
//!
//! Vertices at exactly the same position count as one, as in meshes from STL or along the seams of texture coordinates. Edges are
//! sorted into lists by their smaller vertex; fans of faces around vertices, components and loops are found by union. Time
//! and memory grow linearly: some 60 bytes a face.

use rayon::prelude::*;

use crate::MeshRef;
use crate::places::first_at_place;
use crate::surface::{length, normal};

/// How often something is found, and where first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found<P> {
    /// How often.
    pub count: usize,
    /// The place with the smallest index.
    pub first: Option<P>,
}

impl<P> Default for Found<P> {
    fn default() -> Self {
        Self { count: 0, first: None }
    }
}

impl<P> Found<P> {
    fn add(&mut self, place: P) {
        self.count += 1;
        self.first.get_or_insert(place);
    }
}

/// What [`check`] finds. Faces are given by their index, vertices by the smallest index at their position, edges by both vertices.
///
/// Faces with bad indices or corners that are not finite, and those that name a position twice, are counted as such and then
/// left out: all that follows is about the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Findings {
    /// Faces of the mesh.
    pub faces: usize,
    /// Faces that name a vertex that is not there.
    pub bad_indices: Found<u32>,
    /// Faces with a corner that is not finite.
    pub non_finite: Found<u32>,
    /// Faces that name a position twice.
    pub collapsed: Found<u32>,
    /// Other faces without area: their corners lie on a line.
    pub flat: Found<u32>,
    /// Faces with the same three positions as one before, in whatever order.
    pub duplicates: Found<u32>,
    /// Positions that faces use.
    pub vertices: usize,
    /// Edges of faces.
    pub edges: usize,
    /// Edges of one face.
    pub boundary_edges: Found<[u32; 2]>,
    /// Edges of more than two faces.
    pub non_manifold_edges: Found<[u32; 2]>,
    /// Edges that two faces pass in the same direction.
    pub misoriented_edges: Found<[u32; 2]>,
    /// Vertices where faces meet that no edges there connect.
    pub non_manifold_vertices: Found<u32>,
    /// Connected sets of boundary edges: holes and rims.
    pub boundary_loops: usize,
    /// Sets of faces that share vertices.
    pub components: usize,
}

impl Findings {
    /// Vertices less edges plus faces, of faces that are not left out: 2 for each closed surface without handles.
    pub fn euler_number(&self) -> i64 {
        let faces = self.faces - self.bad_indices.count - self.non_finite.count - self.collapsed.count;
        self.vertices as i64 - self.edges as i64 + faces as i64
    }

    /// True if every edge has exactly two faces, and there are any.
    pub fn is_watertight(&self) -> bool {
        self.edges > 0 && self.boundary_edges.count == 0 && self.non_manifold_edges.count == 0
    }

    /// True if the surface is a manifold, with or without boundary.
    pub fn is_manifold(&self) -> bool {
        self.non_manifold_edges.count == 0 && self.non_manifold_vertices.count == 0
    }

    /// True if every face is a triangle with an area, and none is there twice.
    pub fn is_sound(&self) -> bool {
        let faults = [&self.bad_indices, &self.non_finite, &self.collapsed, &self.flat, &self.duplicates];
        faults.into_iter().all(|found| found.count == 0)
    }
}

/// Checks a mesh. Any mesh is taken, whatever its indices and numbers; attributes are not looked at.
///
/// ```
/// use etendue_simplify::{MeshRef, check};
///
/// let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let mesh = MeshRef { positions: &positions, faces: &faces, normals: None, uvs: None, colors: None, materials: None };
/// let findings = check(&mesh);
/// assert!(findings.is_watertight() && findings.is_sound() && findings.euler_number() == 2);
/// ```
pub fn check(mesh: &MeshRef<'_>) -> Findings {
    let welded = first_at_place(mesh.positions);
    let states: Vec<State> = mesh.faces.par_iter().with_min_len(PART).map(|face| state(mesh, face, &welded)).collect();
    let mut findings = Findings { faces: mesh.faces.len(), ..Findings::default() };
    for (face, state) in states.iter().enumerate() {
        match state {
            State::BadIndex => findings.bad_indices.add(face as u32),
            State::NonFinite => findings.non_finite.add(face as u32),
            State::Collapsed => findings.collapsed.add(face as u32),
            State::Flat => findings.flat.add(face as u32),
            State::Fine => {}
        }
    }
    let topology = Topology { mesh: *mesh, welded: &welded, states: &states };
    topology.vertices(&mut findings);
    let lists = topology.edge_lists();
    topology.edges(&lists, &mut findings);
    findings
}

/// Faces or vertices that a thread works on at once.
const PART: usize = 1 << 13;

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Fine,
    Flat,
    Collapsed,
    NonFinite,
    BadIndex,
}

impl State {
    /// True if the face counts for the topology.
    fn is_in(self) -> bool {
        matches!(self, Self::Fine | Self::Flat)
    }
}

fn state(mesh: &MeshRef<'_>, face: &[u32; 3], welded: &[u32]) -> State {
    if face.iter().any(|&v| v as usize >= mesh.positions.len()) {
        return State::BadIndex;
    }
    let corners = face.map(|v| mesh.positions[v as usize]);
    if !corners.as_flattened().iter().all(|x| x.is_finite()) {
        return State::NonFinite;
    }
    let [a, b, c] = face.map(|v| welded[v as usize]);
    if a == b || b == c || c == a {
        State::Collapsed
    } else if length(normal(corners)) > 0.0 {
        State::Fine
    } else {
        State::Flat
    }
}

/// An edge of a face in the list of its smaller vertex: the other vertex, and three times the face plus the corner it starts at.
type Entry = (u32, u32);

/// The entries of all vertices, one list after the other, and where each ends.
struct Lists {
    entries: Vec<Entry>,
    ends: Vec<usize>,
}

struct Topology<'a> {
    mesh: MeshRef<'a>,
    welded: &'a [u32],
    states: &'a [State],
}

impl Topology<'_> {
    fn corners(&self, face: usize) -> [u32; 3] {
        self.mesh.faces[face].map(|v| self.welded[v as usize])
    }

    /// The faces that count.
    fn faces(&self) -> impl Iterator<Item = (usize, [u32; 3])> {
        self.states.iter().enumerate().filter(|(_, state)| state.is_in()).map(|(face, _)| (face, self.corners(face)))
    }

    /// Counts vertices and components.
    fn vertices(&self, findings: &mut Findings) {
        let mut sets = Sets::new(self.mesh.positions.len());
        let mut is_used = vec![false; self.mesh.positions.len()];
        for (_, [a, b, c]) in self.faces() {
            sets.join(a, b);
            sets.join(b, c);
            [a, b, c].into_iter().for_each(|v| is_used[v as usize] = true);
        }
        findings.vertices = is_used.iter().filter(|&&is_used| is_used).count();
        findings.components = (0..is_used.len()).filter(|&v| is_used[v] && sets.root(v as u32) == v as u32).count();
    }

    fn edge_lists(&self) -> Lists {
        let mut starts = vec![0_usize; self.mesh.positions.len() + 1];
        for (_, corners) in self.faces() {
            for i in 0..3 {
                starts[corners[i].min(corners[(i + 1) % 3]) as usize + 1] += 1;
            }
        }
        for v in 1..starts.len() {
            starts[v] += starts[v - 1];
        }
        let mut entries = vec![(0, 0); starts[starts.len() - 1]];
        // Filling a list moves its start to its end.
        for (face, corners) in self.faces() {
            for i in 0..3 {
                let (a, b) = (corners[i], corners[(i + 1) % 3]);
                let place = &mut starts[a.min(b) as usize];
                entries[*place] = (a.max(b), (3 * face + i) as u32);
                *place += 1;
            }
        }
        let lists = Lists { entries, ends: starts };
        lists.sorted()
    }

    /// Counts all that is about edges and the fans around vertices.
    fn edges(&self, lists: &Lists, findings: &mut Findings) {
        let mut fans = Sets::new(3 * self.mesh.faces.len());
        let mut rims = Sets::new(self.mesh.positions.len());
        let mut is_rim = vec![false; self.mesh.positions.len()];
        let mut duplicates = Vec::new();
        let mut start = 0;
        for (v, &end) in lists.ends[..self.mesh.positions.len()].iter().enumerate() {
            let v = v as u32;
            for run in lists.entries[start..end].chunk_by(|a, b| a.0 == b.0) {
                let edge = [v, run[0].0];
                findings.edges += 1;
                match run {
                    [_] => {
                        findings.boundary_edges.add(edge);
                        rims.join(edge[0], edge[1]);
                        edge.iter().for_each(|&v| is_rim[v as usize] = true);
                    }
                    [one, other] if self.starts_at(one, v) == self.starts_at(other, v) => {
                        findings.misoriented_edges.add(edge);
                    }
                    [_, _] => {}
                    _ => findings.non_manifold_edges.add(edge),
                }
                for pair in run.windows(2) {
                    for vertex in edge {
                        fans.join(self.corner_at(&pair[0], vertex), self.corner_at(&pair[1], vertex));
                    }
                }
                self.duplicates(run, v, &mut duplicates);
            }
            start = end;
        }
        duplicates.sort_unstable();
        duplicates.into_iter().for_each(|face| findings.duplicates.add(face));
        findings.boundary_loops = (0..is_rim.len()).filter(|&v| is_rim[v] && rims.root(v as u32) == v as u32).count();
        self.fans(&mut fans, findings);
    }

    /// Counts vertices with more than one fan.
    fn fans(&self, fans: &mut Sets, findings: &mut Findings) {
        let mut counts = vec![0_u8; self.mesh.positions.len()];
        for (face, corners) in self.faces() {
            for (i, &v) in corners.iter().enumerate() {
                let corner = (3 * face + i) as u32;
                if fans.root(corner) == corner {
                    counts[v as usize] = counts[v as usize].saturating_add(1);
                }
            }
        }
        for (v, _) in counts.iter().enumerate().filter(|&(_, &count)| count > 1) {
            findings.non_manifold_vertices.add(v as u32);
        }
    }

    /// True if the face passes the edge from this vertex.
    fn starts_at(&self, entry: &Entry, vertex: u32) -> bool {
        let (face, corner) = (entry.1 as usize / 3, entry.1 as usize % 3);
        self.corners(face)[corner] == vertex
    }

    /// The corner of an entry's face that is at this vertex.
    fn corner_at(&self, entry: &Entry, vertex: u32) -> u32 {
        let face = entry.1 / 3;
        let at = self.corners(face as usize).iter().position(|&v| v == vertex).unwrap_or_default();
        3 * face + at as u32
    }

    /// Lists the faces at an edge whose third vertex another face has too, if the edge joins the smallest two.
    fn duplicates(&self, run: &[Entry], v: u32, duplicates: &mut Vec<u32>) {
        if run.len() < 2 {
            return;
        }
        let third = |entry: &Entry| {
            let corners = self.corners(entry.1 as usize / 3);
            corners.into_iter().find(|&c| c != v && c != entry.0).unwrap_or_default()
        };
        if let [one, other] = run
            && third(one) != third(other)
        {
            return;
        }
        let mut faces: Vec<(u32, u32)> = run.iter().map(|entry| (third(entry), entry.1 / 3)).collect();
        faces.sort_unstable();
        let again = faces.windows(2).filter(|pair| pair[0].0 == pair[1].0 && pair[0].0 > run[0].0);
        duplicates.extend(again.map(|pair| pair[1].1));
    }
}

impl Lists {
    /// Sorts every list.
    fn sorted(mut self) -> Self {
        let mut rest = &mut self.entries[..];
        let mut lists = Vec::new();
        let mut start = 0;
        for ends in self.ends.chunks(PART) {
            let end = ends[ends.len() - 1];
            let (part, after) = rest.split_at_mut(end - start);
            lists.push((start, ends, part));
            (rest, start) = (after, end);
        }
        lists.into_par_iter().for_each(|(first, ends, part)| {
            let mut start = first;
            for &end in ends {
                part[start - first..end - first].sort_unstable();
                start = end;
            }
        });
        self
    }
}

/// Disjoint sets of numbers; the root of a set is its smallest number.
struct Sets(Vec<u32>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count).map(|i| i as u32).collect())
    }

    fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            let parent = self.0[i as usize];
            self.0[i as usize] = self.0[parent as usize];
            i = parent;
        }
        i
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
