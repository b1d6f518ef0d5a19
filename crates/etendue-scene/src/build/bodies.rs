//! Bodies that hold something must be closed: otherwise paths that find a hole take its medium along.

use crate::weld::Welder;
use etendue::{
    material::Material,
    math::Vec3,
    scene::{Mesh, Object, SceneParts, Shape},
};
use std::collections::BTreeMap;

/// What was found of shapes with some of their materials' faces taken.
#[derive(Default)]
pub struct Closed {
    open_edges: BTreeMap<(usize, Vec<bool>), usize>,
}

impl Closed {
    /// Edges of an object's bodies that have no partner, 0 where all are closed or there are none; of bodies alike only once.
    pub fn open_edges(&mut self, parts: &SceneParts, object: &Object) -> usize {
        let body = |material: &usize| body_of(&parts.materials[*material]);
        let mut bodies: Vec<_> = object.materials.iter().filter_map(body).collect();
        bodies.sort_unstable();
        bodies.dedup();
        let each = bodies.into_iter().map(|wanted| {
            let taken: Vec<bool> = object.materials.iter().map(|material| body(material) == Some(wanted)).collect();
            let count = || open_edges(&parts.shapes[object.shape], &taken);
            *self.open_edges.entry((object.shape, taken.clone())).or_insert_with(count)
        });
        each.sum()
    }
}

/// What tells the bodies of an object apart; `None` for materials that bound none.
fn body_of(material: &Material) -> Option<(Option<&str>, i32)> {
    let is_body = material.interior.is_some() || material.priority.is_some();
    is_body.then(|| (material.interior.as_deref(), material.priority.unwrap_or(0)))
}

fn open_edges(shape: &Shape, taken: &[bool]) -> usize {
    match shape {
        Shape::Sphere { .. } => 0,
        Shape::Rectangle { .. } => 4,
        Shape::Mesh(mesh) => open_edges_of(mesh, taken),
    }
}

/// Every edge must be gone along as often one way as the other.
fn open_edges_of(mesh: &Mesh, taken: &[bool]) -> usize {
    let mut welder = Welder::default();
    let number = |p: &[f32; 3]| welder.number(Vec3::from(*p).as_dvec3()).unwrap_or(u32::MAX);
    let numbers: Vec<u32> = mesh.positions.iter().map(number).collect();
    let is_taken = |face: usize| match &mesh.face_materials {
        Some(slots) if taken.len() > 1 => taken.get(slots[face] as usize).copied().unwrap_or(false),
        _ => taken.first().copied().unwrap_or(false),
    };
    let faces = mesh.indices.iter().enumerate().filter(|(face, _)| is_taken(*face));
    let mut edges: Vec<(u32, u32, i8)> = faces
        .flat_map(|(_, corners)| {
            let [a, b, c] = corners.map(|corner| numbers.get(corner as usize).copied().unwrap_or(u32::MAX));
            [(a, b), (b, c), (c, a)].map(|(a, b)| if a < b { (a, b, 1) } else { (b, a, -1) })
        })
        .filter(|(a, b, _)| a != b)
        .collect();
    edges.sort_unstable();
    let groups = edges.chunk_by(|first, second| (first.0, first.1) == (second.0, second.1));
    groups.filter(|group| group.iter().map(|(_, _, way)| i64::from(*way)).sum::<i64>() != 0).count()
}
