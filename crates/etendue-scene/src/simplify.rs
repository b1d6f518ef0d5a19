//! Meshes of files and scenes with fewer faces: between the simplifier's flat arrays and the renderer's meshes.

use crate::{
    Diagnostic, Origin,
    mesh_file::{MeshFile, Numbering},
};
use etendue::scene::Mesh;
use etendue_simplify::{
    Keep, MeshRef, Method, Options, Placement, Progress, Report, SIGMA, SimplifyError, Target, simplify,
};
use glam::DVec3;
use std::ops::ControlFlow;

/// Every method, with its name in scene files and on the command line.
pub const METHODS: [(&str, Method); 3] =
    [("quadric", Method::Quadric), ("quadric-union", Method::QuadricUnion), ("shortest-edge", Method::ShortestEdge)];

/// Every placement that can be asked for, with its name.
pub const PLACEMENTS: [(&str, Placement); 4] = [
    ("probabilistic", Placement::Probabilistic { sigma: SIGMA }),
    ("perturbed", Placement::Perturbed),
    ("endpoint", Placement::Endpoint),
    ("midpoint", Placement::Midpoint),
];

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// At most so many faces.
    Faces(usize),
    /// At most this fraction of the input's faces, in (0, 1].
    Ratio(f64),
    /// The fewest faces whose measured distance is at most this, in the unit of the mesh.
    Error(f64),
    /// The same, as a fraction of the diagonal of the mesh's bounding box.
    RelativeError(f64),
}

impl Goal {
    /// A distance as people write it, `0.02` or `0.5%` of the diagonal; `None` if it is not above 0.
    pub fn of_distance(text: &str) -> Option<Self> {
        let above_zero = |text: &str| text.trim().parse().ok().filter(|d: &f64| d.is_finite() && *d > 0.0);
        match text.trim().strip_suffix('%') {
            Some(percents) => above_zero(percents).map(|p| Self::RelativeError(p / 100.0)),
            None => above_zero(text).map(Self::Error),
        }
    }

    /// For a mesh, whose diagonal may be needed.
    pub fn target(self, mesh: &Mesh) -> Target {
        match self {
            Self::Faces(faces) => Target::Faces(faces),
            Self::Ratio(ratio) => Target::Ratio(ratio),
            Self::Error(error) => Target::Error(error),
            Self::RelativeError(fraction) => Target::Error(fraction * diagonal(mesh)),
        }
    }
}

/// Length of the diagonal of the box about all vertices; 0 without vertices.
pub fn diagonal(mesh: &Mesh) -> f64 {
    let points = || mesh.positions.iter().map(|p| DVec3::from_array(p.map(f64::from)));
    let (min, max) = (points().reduce(DVec3::min), points().reduce(DVec3::max));
    min.zip(max).map_or(0.0, |(min, max)| (max - min).length())
}

/// How a mesh of a scene is simplified; see [`Options`].
#[derive(Clone, Debug, PartialEq)]
pub struct SimplifyRecord {
    /// When to stop.
    pub goal: Goal,
    /// What a collapse costs.
    pub method: Method,
    /// Where vertices go.
    pub placement: Placement,
    /// True if vertices of open edges stay.
    pub keep_boundary: bool,
    /// Degrees, in (0, 180]; absent: the simplifier's default.
    pub crease_angle: Option<f64>,
    /// Less care, more speed.
    pub fast: bool,
    /// True if vertices are moved towards the original at the end.
    pub polish: bool,
    /// For what is random.
    pub seed: u64,
    /// Where it is asked for.
    pub origin: Origin,
}

impl SimplifyRecord {
    fn options(&self, mesh: &Mesh) -> Options {
        let defaults = Options::new(self.goal.target(mesh));
        Options {
            method: self.method,
            placement: self.placement,
            keep_boundary: self.keep_boundary,
            crease_angle: self.crease_angle.map_or(defaults.crease_angle, f64::to_radians),
            fast: self.fast,
            polish: self.polish,
            seed: self.seed,
            ..defaults
        }
    }

    /// The simplified mesh, and what there is to tell.
    pub(crate) fn apply(&self, mesh: &Mesh) -> (Option<Mesh>, Diagnostic) {
        match simplify_mesh(mesh, &self.options(mesh), &mut |_| ControlFlow::Continue(())) {
            Ok((mesh, report)) => (Some(mesh), told(&report).at(self.origin.clone())),
            Err(error) => (None, Diagnostic::error(format!("cannot simplify: {error}")).at(self.origin.clone())),
        }
    }
}

fn told(report: &Report) -> Diagnostic {
    let Report { faces_in, faces_out, turned, stopped, .. } = report;
    match stopped {
        None if *turned > 0 => Diagnostic::warning(format!(
            "simplified from {faces_in} to {faces_out} triangles, {turned} of them turned over"
        )),
        None => Diagnostic::note(format!("simplified from {faces_in} to {faces_out} triangles")),
        Some(stopped) => {
            Diagnostic::warning(format!("simplified from {faces_in} to no less than {faces_out} triangles: {stopped}"))
        }
    }
}

/// A mesh as the simplifier takes it; positions without the origin.
pub fn borrowed(mesh: &Mesh) -> MeshRef<'_> {
    MeshRef {
        positions: &mesh.positions,
        faces: &mesh.indices,
        normals: mesh.normals.as_deref(),
        uvs: mesh.uvs.as_deref(),
        colors: mesh.colors.as_deref(),
        materials: mesh.face_materials.as_deref(),
    }
}

/// The simplified mesh, and how it went.
///
/// # Errors
/// Those of [`simplify`].
pub fn simplify_mesh(
    mesh: &Mesh,
    options: &Options,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<(Mesh, Report), SimplifyError> {
    let done = simplify(&borrowed(mesh), options, progress)?;
    let mut simple = done.mesh;
    if let Some(materials) = &mut simple.materials {
        // Faces of one material follow each other, as in most files.
        let mut order: Vec<usize> = (0..simple.faces.len()).collect();
        order.sort_by_key(|&face| materials[face]);
        simple.faces = order.iter().map(|&face| simple.faces[face]).collect();
        materials.sort_unstable();
    }
    let mesh = Mesh {
        origin: mesh.origin,
        positions: simple.positions.into(),
        indices: simple.faces.into(),
        normals: simple.normals.map(Into::into),
        uvs: simple.uvs.map(Into::into),
        colors: simple.colors.map(Into::into),
        face_materials: simple.materials.map(Into::into),
    };
    Ok((mesh, done.report))
}

/// Takes away what is not to be kept: attributes of vertices, and materials with their borders.
pub fn keep_only(file: &mut MeshFile, keep: Keep) {
    if !keep.uvs {
        file.mesh.uvs = None;
    }
    if !keep.normals {
        file.mesh.normals = None;
    }
    if !keep.colors {
        file.mesh.colors = None;
    }
    if !keep.materials {
        file.mesh.face_materials = None;
        file.materials.clear();
        file.spheres.iter_mut().for_each(|sphere| sphere.material = 0);
    }
}

/// A mesh file with a simplified mesh, and how it went. Groups are lost, since their faces are.
///
/// # Errors
/// Those of [`simplify`].
pub fn simplify_file(
    file: &MeshFile,
    options: &Options,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<(MeshFile, Report), SimplifyError> {
    let (mesh, report) = simplify_mesh(&file.mesh, options, progress)?;
    let simplified = MeshFile {
        numbering: Numbering::same(mesh.positions.len()),
        mesh,
        spheres: file.spheres.clone(),
        materials: file.materials.clone(),
        groups: vec![],
        keys: file.keys.clone(),
        notes: file.notes.clone(),
    };
    Ok((simplified, report))
}
