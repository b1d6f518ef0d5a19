//! Collision shapes from solids.

use crate::{
    convert::{rotation, vector},
    mesh::Triangles,
    solid::{Solid, corners, thickened},
};
use etendue::math::{DQuat, DVec3};
use etendue_scene::physics::CollisionShape;
use rapier3d_f64::{
    parry::{
        shape::ConvexPolyhedron,
        transformation::{
            try_convex_hull,
            vhacd::{VHACD, VHACDParameters},
            voxelization::FillMode,
        },
    },
    prelude::{Pose, SharedShape, TriMesh, TriMeshFlags, Vector},
};

/// A mesh's volume over that of its convex hull, from which on it counts as convex.
const CONVEX: f64 = 0.995;
/// Voxels along the longest side of what is decomposed.
const RESOLUTION: u32 = 64;
/// Convex pieces of a mesh.
const MAX_PIECES: u32 = 64;
/// What is flatter than this share of its size is thickened by as much before its hull is made.
const FLAT: f64 = 1e-3;
/// What is narrower than this share of its length is a line.
const THIN: f64 = 1e-9;

/// A part of a collision shape and where it is, in the body's space.
pub type Part = (Pose, SharedShape);

/// The collision shape of a body's solids; `pushed` if forces move it. An error says what is wrong with the body.
pub fn shape(solids: &[Solid], shape: CollisionShape, pushed: bool) -> Result<Vec<Part>, String> {
    match shape {
        CollisionShape::Sphere => Ok(vec![sphere(solids)]),
        CollisionShape::Box => Ok(vec![bounding_box(solids, pushed)]),
        CollisionShape::Hull => {
            let points: Vec<DVec3> = solids.iter().flat_map(Solid::points).collect();
            hull(&points).map(|shape| vec![(Pose::IDENTITY, shape)])
        }
        CollisionShape::Auto | CollisionShape::Mesh | CollisionShape::Decomposed => {
            let parts: Result<Vec<Vec<Part>>, String> = solids.iter().map(|solid| part(solid, shape, pushed)).collect();
            Ok(parts?.concat())
        }
    }
}

fn part(solid: &Solid, shape: CollisionShape, pushed: bool) -> Result<Vec<Part>, String> {
    Ok(match solid {
        Solid::Ball { center, radius } => vec![(Pose::from_translation(vector(*center)), SharedShape::ball(*radius))],
        Solid::Ellipsoid { .. } => vec![(Pose::IDENTITY, hull(&solid.points())?)],
        Solid::Box { center, rotation, half } => {
            vec![cuboid(*center, *rotation, if pushed { thickened(*half) } else { *half })]
        }
        Solid::Mesh { triangles, is_closed } => match shape {
            CollisionShape::Mesh => vec![surface(triangles, *is_closed)?],
            CollisionShape::Auto if !pushed => vec![surface(triangles, *is_closed)?],
            CollisionShape::Auto if is_convex(triangles, *is_closed) => {
                vec![(Pose::IDENTITY, hull(&triangles.vertices)?)]
            }
            _ => decomposed(triangles, *is_closed)?,
        },
    })
}

fn cuboid(center: DVec3, turn: DQuat, half: DVec3) -> Part {
    (Pose::from_parts(vector(center), rotation(turn)), SharedShape::cuboid(half.x, half.y, half.z))
}

/// Lowest and highest corner of the box about all solids.
fn bounds(solids: &[Solid]) -> (DVec3, DVec3) {
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    for solid in solids {
        let around = match solid {
            Solid::Ball { center, radius } => corners(DVec3::splat(*radius)).map(|p| *center + p).to_vec(),
            other => other.points(),
        };
        for p in around {
            low = low.min(p);
            high = high.max(p);
        }
    }
    (low, high)
}

fn bounding_box(solids: &[Solid], pushed: bool) -> Part {
    let (low, high) = bounds(solids);
    let half = 0.5 * (high - low);
    cuboid(0.5 * (low + high), DQuat::IDENTITY, if pushed { thickened(half) } else { half })
}

fn sphere(solids: &[Solid]) -> Part {
    let (low, high) = bounds(solids);
    let center = 0.5 * (low + high);
    let reach = |solid: &Solid| match solid {
        Solid::Ball { center: middle, radius } => (*middle - center).length() + radius,
        other => other.points().iter().map(|p| (*p - center).length()).fold(0.0, f64::max),
    };
    let radius = solids.iter().map(reach).fold(0.0, f64::max);
    (Pose::from_translation(vector(center)), SharedShape::ball(radius))
}

/// Triangles as they are; those of an open surface are touched from both sides.
fn surface(triangles: &Triangles, is_closed: bool) -> Result<Part, String> {
    let edges = if is_closed { TriMeshFlags::FIX_INTERNAL_EDGES } else { TriMeshFlags::FIX_INTERNAL_EDGES_TWO_SIDED };
    let flags = edges | TriMeshFlags::DELETE_DEGENERATE_TRIANGLES | TriMeshFlags::DELETE_DUPLICATE_TRIANGLES;
    let mut faces = triangles.faces.clone();
    if is_closed && triangles.volume() < 0.0 {
        faces.iter_mut().for_each(|face| face.swap(0, 1));
    }
    let mesh = TriMesh::with_flags(points(&triangles.vertices), faces, flags);
    let mesh = mesh.map_err(|error| format!("has triangles that do not collide: {error}"))?;
    Ok((Pose::IDENTITY, SharedShape::new(mesh)))
}

fn points(positions: &[DVec3]) -> Vec<Vector> {
    positions.iter().map(|p| vector(*p)).collect()
}

fn is_convex(triangles: &Triangles, is_closed: bool) -> bool {
    if !is_closed {
        return false;
    }
    let Ok((vertices, faces)) = try_convex_hull(&points(&triangles.vertices)) else { return false };
    let hull = Triangles { vertices: vertices.iter().map(|p| crate::convert::from_vector(*p)).collect(), faces };
    triangles.volume().abs() >= CONVEX * hull.volume().abs()
}

/// The convex hull, of flat things a little thicker than they are.
fn hull(positions: &[DVec3]) -> Result<SharedShape, String> {
    let mut around = positions.to_vec();
    if let Extent::Sheet(normal) = Extent::of(positions)? {
        around.clear();
        around.extend(positions.iter().flat_map(|p| [*p - normal, *p + normal]));
    }
    let (vertices, faces) =
        try_convex_hull(&points(&around)).map_err(|error| format!("has no convex hull: {error}"))?;
    let polyhedron = ConvexPolyhedron::from_convex_mesh(vertices, &faces);
    polyhedron.map(SharedShape::new).ok_or_else(|| "has no convex hull".to_owned())
}

/// How many dimensions points fill.
enum Extent {
    /// Two: half of the edge, across them, that makes a solid of them.
    Sheet(DVec3),
    /// Three.
    Solid,
}

impl Extent {
    /// An error if they are all on a line.
    fn of(positions: &[DVec3]) -> Result<Self, String> {
        let line = || "is as thin as a line".to_owned();
        let first = *positions.first().ok_or_else(line)?;
        let farthest = |from: &dyn Fn(DVec3) -> f64| {
            positions.iter().copied().max_by(|a, b| from(*a).total_cmp(&from(*b))).unwrap_or(first)
        };
        let along = farthest(&|p| (p - first).length()) - first;
        let size = along.length();
        let across = farthest(&|p| (p - first).cross(along).length()) - first;
        let area = along.cross(across);
        let is_wide = area.length() > THIN * size * size;
        if !is_wide {
            return Err(line());
        }
        let normal = area.normalize();
        let thickness = positions.iter().map(|p| (*p - first).dot(normal).abs()).fold(0.0, f64::max);
        Ok(if thickness < FLAT * size { Self::Sheet(normal * (0.5 * FLAT * size)) } else { Self::Solid })
    }
}

/// Convex pieces (Mamou, Lengyel, Peters, "Volumetric hierarchical approximate convex decomposition", 2016).
fn decomposed(triangles: &Triangles, is_closed: bool) -> Result<Vec<Part>, String> {
    if let Extent::Sheet(_) = Extent::of(&triangles.vertices)? {
        return Ok(vec![(Pose::IDENTITY, hull(&triangles.vertices)?)]);
    }
    let fill_mode = match is_closed {
        true => FillMode::FloodFill { detect_cavities: false },
        false => FillMode::SurfaceOnly,
    };
    let parameters =
        VHACDParameters { resolution: RESOLUTION, max_convex_hulls: MAX_PIECES, fill_mode, ..Default::default() };
    let pieces = VHACD::decompose(&parameters, &points(&triangles.vertices), &triangles.faces, false);
    let pieces = pieces.compute_convex_hulls(parameters.convex_hull_downsampling);
    let shape = |(vertices, faces): (Vec<Vector>, Vec<[u32; 3]>)| ConvexPolyhedron::from_convex_mesh(vertices, &faces);
    let parts: Vec<Part> =
        pieces.into_iter().filter_map(shape).map(|shape| (Pose::IDENTITY, SharedShape::new(shape))).collect();
    if parts.is_empty() {
        return Err("cannot be cut into convex pieces".to_owned());
    }
    Ok(parts)
}
