//! How far two surfaces are from each other, measured (after Cignoni, Rocchini and Scopigno, "Metro: measuring error on
//! simplified surfaces", 1998).

use std::ops::ControlFlow;

use etendue_accel::{ClosestPoint, ClosestPoints};

use crate::scale::Scale;
use crate::surface::{self, Areas, Sample, is_in_reach};
use crate::{MeshRef, Progress, SimplifyError, Stage};

/// Points that are measured between two calls of the progress callback.
const BLOCK: usize = 1 << 16;

/// Distances of one surface's points to another surface, in the unit of positions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OneWay {
    /// Root of the mean square over the area, from the samples alone; 0 without any.
    pub rms: f64,
    /// Mean over the area, from the samples alone; 0 without any.
    pub mean: f64,
    /// The largest of samples and vertices.
    pub largest: f64,
    /// A point that is so far away.
    pub farthest: [f64; 3],
}

/// How far two surfaces are from each other, in the unit of positions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distance {
    /// From the first to the second.
    pub forth: OneWay,
    /// From the second to the first.
    pub back: OneWay,
    /// Of the first surface's bounding box.
    pub diagonal: f64,
}

impl Distance {
    /// The larger of both root mean squares.
    pub fn rms(&self) -> f64 {
        self.forth.rms.max(self.back.rms)
    }

    /// The Hausdorff distance, as far as samples and vertices find it: never above the true one but for rounding.
    pub fn largest(&self) -> f64 {
        self.forth.largest.max(self.back.largest)
    }
}

/// Measures the distance of two surfaces, both ways: from `samples` points of each, stratified by area, and from all vertices that
/// faces use. The same numbers for any number of threads. Faces with a corner that is not finite are left out; meshes
/// without a face are an error.
///
/// ```
/// use std::ops::ControlFlow;
/// use etendue_simplify::{MeshRef, distance};
///
/// let faces = [[0, 1, 2], [0, 2, 3]];
/// let square = |z| [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
/// let mesh = |positions| MeshRef { positions, faces: &faces, normals: None, uvs: None, colors: None, materials: None };
/// let (low, high) = (square(0.0), square(0.25));
/// let distance = distance(&mesh(&low), &mesh(&high), 1000, 0, &mut |_| ControlFlow::Continue(()))?;
/// assert!((distance.rms() - 0.25).abs() < 1e-12 && (distance.largest() - 0.25).abs() < 1e-12);
/// # Ok::<(), etendue_simplify::SimplifyError>(())
/// ```
pub fn distance(
    a: &MeshRef<'_>,
    b: &MeshRef<'_>,
    samples: usize,
    seed: u64,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Distance, SimplifyError> {
    surface::check_indices(a)?;
    surface::check_indices(b)?;
    let Some(scale) = Scale::of(&[a, b]) else {
        return between(&Side::of(a)?, &Side::of(b)?, samples, seed, progress);
    };
    let (near_a, near_b) = (scale.positions(a), scale.positions(b));
    let (a, b) = (MeshRef { positions: &near_a, ..*a }, MeshRef { positions: &near_b, ..*b });
    between(&Side::of(&a)?, &Side::of(&b)?, samples, seed, progress).map(|distance| scale.undone(distance))
}

/// A surface ready to be measured against others.
pub(crate) struct Side<'a> {
    mesh: MeshRef<'a>,
    vertices: Vec<u32>,
    areas: Areas<'a>,
    search: ClosestPoints,
}

impl<'a> Side<'a> {
    /// Of a mesh whose indices have been checked.
    pub fn of(mesh: &MeshRef<'a>) -> Result<Self, SimplifyError> {
        let vertices = used_vertices(mesh);
        if vertices.is_empty() {
            return Err(SimplifyError::NoSurface);
        }
        Ok(Self { mesh: *mesh, vertices, areas: Areas::of(mesh), search: surface::search(mesh)? })
    }

    /// The diagonal of the bounding box.
    pub fn diagonal(&self) -> f64 {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for &vertex in &self.vertices {
            let point = self.mesh.positions[vertex as usize];
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        surface::length([0, 1, 2].map(|axis| f64::from(high[axis]) - f64::from(low[axis])))
    }
}

/// See [`distance`].
pub(crate) fn between(
    a: &Side<'_>,
    b: &Side<'_>,
    samples: usize,
    seed: u64,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Distance, SimplifyError> {
    let total = 2 * samples + a.vertices.len() + b.vertices.len();
    let mut meter = Meter { total, done: 0, progress, block: Block::default() };
    let forth = meter.one_way(a, &b.search, samples, seed)?;
    let back = meter.one_way(b, &a.search, samples, seed.wrapping_add(1))?;
    Ok(Distance { forth, back, diagonal: a.diagonal() })
}

/// Vertices of faces that are in reach, in ascending order. Faces with two corners at one place count where there is nothing
/// else.
fn used_vertices(mesh: &MeshRef<'_>) -> Vec<u32> {
    let corners = |face: &[u32; 3]| face.map(|v| mesh.positions[v as usize]);
    let of_faces = |counts: &dyn Fn([[f32; 3]; 3]) -> bool| -> Vec<u32> {
        let mut is_used = vec![false; mesh.positions.len()];
        for face in
            mesh.faces.iter().filter(|&face| corners(face).into_iter().all(is_in_reach) && counts(corners(face)))
        {
            face.iter().for_each(|&v| is_used[v as usize] = true);
        }
        (0..is_used.len()).filter(|&v| is_used[v]).map(|v| v as u32).collect()
    };
    let vertices = of_faces(&|[a, b, c]| a != b && b != c && c != a);
    if vertices.is_empty() { of_faces(&|_| true) } else { vertices }
}

/// The points of a block and what is found for them.
#[derive(Default)]
struct Block {
    samples: Vec<Sample>,
    points: Vec<[f64; 3]>,
    found: Vec<ClosestPoint>,
}

struct Meter<'a> {
    total: usize,
    done: usize,
    progress: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
    block: Block,
}

impl Meter<'_> {
    fn one_way(
        &mut self,
        from: &Side<'_>,
        to: &ClosestPoints,
        samples: usize,
        seed: u64,
    ) -> Result<OneWay, SimplifyError> {
        let mut result = OneWay::default();
        for block in from.vertices.chunks(BLOCK) {
            self.block.points.clear();
            self.block.points.extend(block.iter().map(|&v| from.mesh.positions[v as usize].map(f64::from)));
            self.measure(to, &mut result)?;
        }
        let areas = &from.areas;
        if areas.total() == 0.0 {
            // Needles and points alone: what their corners are away stands for all.
            (result.rms, result.mean) = (result.largest, result.largest);
            return Ok(result);
        }
        let (mut sum, mut squares) = (0.0, 0.0);
        for first in (0..samples).step_by(BLOCK) {
            let nowhere = Sample { point: [0.0; 3], face: 0 };
            self.block.samples.resize(BLOCK.min(samples - first), nowhere);
            areas.sample(first, samples, seed, &mut self.block.samples);
            self.block.points.clear();
            self.block.points.extend(self.block.samples.iter().map(|sample| sample.point));
            self.measure(to, &mut result)?;
            for found in &self.block.found {
                sum += found.distance_squared.sqrt();
                squares += found.distance_squared;
            }
        }
        if samples > 0 {
            (result.mean, result.rms) = (sum / samples as f64, (squares / samples as f64).sqrt());
        }
        Ok(result)
    }

    /// Finds what is closest to the block's points.
    fn measure(&mut self, to: &ClosestPoints, result: &mut OneWay) -> Result<(), SimplifyError> {
        let Block { points, found, .. } = &mut self.block;
        found.resize(points.len(), ClosestPoint::NONE);
        to.closest(points, f64::INFINITY, found);
        for (point, found) in points.iter().zip(&*found) {
            let distance = found.distance_squared.sqrt();
            if distance > result.largest {
                (result.largest, result.farthest) = (distance, *point);
            }
        }
        self.done += points.len();
        let done = (self.done as f64 / self.total as f64) as f32;
        match (self.progress)(Progress { stage: Stage::Measure, done }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(SimplifyError::Interrupted),
        }
    }
}
