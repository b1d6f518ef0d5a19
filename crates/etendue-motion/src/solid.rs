//! What an object is, in the space of its body: spheres, boxes, sheets and triangles.

use crate::{
    frame::Frame,
    mesh::{Triangles, sphere_points},
};
use etendue::{
    math::{DMat3, DQuat, DVec3},
    scene::{Mesh, Object, SceneParts, Shape},
};

/// A box's volume and a mesh's may differ by this share for the mesh to be the box.
const SAME_VOLUME: f64 = 1e-6;

/// Thickness of a rectangle that is pushed over its shorter edge.
const SHEET: f64 = 0.01;

/// One shape of an object.
#[derive(Clone, Debug)]
pub enum Solid {
    /// A sphere.
    Ball {
        /// Metres.
        center: DVec3,
        /// Metres.
        radius: f64,
    },
    /// A sphere that is stretched: `center + map * unit sphere`.
    Ellipsoid {
        /// Metres.
        center: DVec3,
        /// Of the unit sphere.
        map: DMat3,
    },
    /// A box along the axes turned by `rotation`; half of its edges may be 0 along z: a rectangle.
    Box {
        /// Metres.
        center: DVec3,
        /// Of its axes.
        rotation: DQuat,
        /// Metres.
        half: DVec3,
    },
    /// Anything else.
    Mesh {
        /// Its surface.
        triangles: Triangles,
        /// It bounds a volume.
        is_closed: bool,
    },
}

impl Solid {
    /// Of one of an object's shapes. `None` for a mesh without faces.
    pub fn new(shape: &Shape, frame: &Frame) -> Option<Self> {
        Some(match *shape {
            Shape::Sphere { center, radius } => {
                let center = frame.local(center);
                match frame.uniform() {
                    Some(scale) => Self::Ball { center, radius: radius * scale },
                    None => Self::Ellipsoid { center, map: frame.stretch * radius },
                }
            }
            Shape::Rectangle { corner, u, v } => rectangle(frame.local(corner), frame.stretch * u, frame.stretch * v),
            Shape::Mesh(ref mesh) => of_mesh(mesh, frame)?,
        })
    }

    /// Points whose convex hull is that of the solid, or close to it.
    pub fn points(&self) -> Vec<DVec3> {
        match self {
            Self::Ball { center, radius } => sphere_points(8).into_iter().map(|p| *center + p * *radius).collect(),
            Self::Ellipsoid { center, map } => sphere_points(8).into_iter().map(|p| *center + *map * p).collect(),
            Self::Box { center, rotation, half } => corners(*half).map(|p| *center + *rotation * p).to_vec(),
            Self::Mesh { triangles, .. } => triangles.vertices.clone(),
        }
    }
}

/// Half of the edges of a box, of a sheet those of one that is not quite flat.
pub fn thickened(half: DVec3) -> DVec3 {
    let [least, middle, most] = {
        let mut edges = half.to_array();
        edges.sort_unstable_by(f64::total_cmp);
        edges
    };
    if least > 1e-9 * most { half } else { half.max(DVec3::splat(SHEET * middle)) }
}

/// The corners of a box about the origin.
pub fn corners(half: DVec3) -> [DVec3; 8] {
    let side = |i: usize, bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
    std::array::from_fn(|i| half * DVec3::new(side(i, 0), side(i, 1), side(i, 2)))
}

fn rectangle(corner: DVec3, u: DVec3, v: DVec3) -> Solid {
    let (a, b) = (u.normalize(), v.normalize());
    if a.dot(b).abs() > 1e-9 {
        let corners = [corner, corner + u, corner + u + v, corner, corner + u + v, corner + v];
        return Solid::Mesh { triangles: Triangles::weld(&corners), is_closed: false };
    }
    let rotation = DQuat::from_mat3(&DMat3::from_cols(a, b, a.cross(b))).normalize();
    let half = DVec3::new(0.5 * u.length(), 0.5 * v.length(), 0.0);
    Solid::Box { center: corner + 0.5 * (u + v), rotation, half }
}

fn of_mesh(mesh: &Mesh, frame: &Frame) -> Option<Solid> {
    let corner = |&i: &u32| mesh.origin + DVec3::from_array(mesh.positions[i as usize].map(f64::from));
    let corners: Vec<DVec3> = mesh.indices.iter().flatten().map(|i| frame.local(corner(i))).collect();
    let triangles = Triangles::weld(&corners);
    if triangles.faces.is_empty() {
        return None;
    }
    let is_closed = triangles.is_closed();
    let (low, high) = triangles.bounds();
    let size = high - low;
    let full = size.x * size.y * size.z;
    // A closed surface that fills its bounding box is the box.
    if is_closed && frame.is_diagonal && (triangles.volume().abs() - full).abs() <= SAME_VOLUME * full {
        return Some(Solid::Box { center: 0.5 * (low + high), rotation: DQuat::IDENTITY, half: 0.5 * size });
    }
    Some(Solid::Mesh { triangles, is_closed })
}

/// Lowest and highest corner of the box about an object's shapes, in its own space; `None` if there is nothing in it.
pub fn bounds(parts: &SceneParts, objects: &[Object]) -> Option<(DVec3, DVec3)> {
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    let mut add = |p: DVec3| {
        low = low.min(p);
        high = high.max(p);
    };
    for object in objects {
        match parts.shapes.get(object.shape)? {
            Shape::Sphere { center, radius } => [-*radius, *radius].into_iter().for_each(|r| add(*center + r)),
            Shape::Rectangle { corner, u, v } => {
                [DVec3::ZERO, *u, *v, *u + *v].into_iter().for_each(|p| add(*corner + p));
            }
            Shape::Mesh(mesh) => {
                let position = |&i: &u32| mesh.positions.get(i as usize);
                let used = mesh.indices.iter().flatten().filter_map(position);
                used.for_each(|p| add(mesh.origin + DVec3::from_array(p.map(f64::from))));
            }
        }
    }
    low.cmple(high).all().then_some((low, high))
}
