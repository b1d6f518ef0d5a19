//! What is labelled: the objects of a scene file.

use crate::{
    math::{DAffine3, DVec3, Vec3},
    scene::{Mesh, SceneParts, Shape},
};

/// One object of a scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// As in the scene file.
    pub name: String,
    /// From its own space to the world where nothing moves.
    pub transform: DAffine3,
    /// Lowest and highest corner of the axis-aligned box about it in its own space, metres; absent: it has no surface.
    pub bounds: Option<[DVec3; 2]>,
    /// The first of [`SceneParts::objects`] that it is made of, and the end of their range.
    pub objects: [usize; 2],
}

/// The objects of a scene file in their order, which gives the ids: the first is 1.
///
/// A file may come as more than one of [`SceneParts::objects`] (spheres beside its mesh): those that follow each other with one
/// name and one transform are one subject.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Subjects {
    list: Vec<Subject>,
    /// Of each object of the parts.
    of_object: Vec<u32>,
}

impl Subjects {
    /// Those of `parts`.
    pub fn of(parts: &SceneParts) -> Self {
        let mut subjects = Self::default();
        for (number, object) in parts.objects.iter().enumerate() {
            let bounds = parts.shapes.get(object.shape).and_then(bounds);
            let piece_of = |last: &Subject| last.name == object.name && last.transform == object.transform;
            match subjects.list.last_mut().filter(|last| piece_of(last)) {
                Some(last) => {
                    last.bounds = union(last.bounds, bounds);
                    last.objects[1] = number + 1;
                }
                None => subjects.list.push(Subject {
                    name: object.name.clone(),
                    transform: object.transform,
                    bounds,
                    objects: [number, number + 1],
                }),
            }
            subjects.of_object.push(subjects.list.len() as u32 - 1);
        }
        subjects
    }

    /// In the order of their ids.
    pub fn list(&self) -> &[Subject] {
        &self.list
    }

    /// How many objects the parts have.
    pub fn objects(&self) -> usize {
        self.of_object.len()
    }

    /// The id of an object of the parts.
    pub fn id(&self, object: u32) -> u32 {
        self.of_object[object as usize] + 1
    }
}

fn union(a: Option<[DVec3; 2]>, b: Option<[DVec3; 2]>) -> Option<[DVec3; 2]> {
    match (a, b) {
        (Some(a), Some(b)) => Some([a[0].min(b[0]), a[1].max(b[1])]),
        (one, None) | (None, one) => one,
    }
}

fn bounds(shape: &Shape) -> Option<[DVec3; 2]> {
    match shape {
        Shape::Sphere { center, radius } => Some([*center - DVec3::splat(*radius), *center + DVec3::splat(*radius)]),
        Shape::Rectangle { corner, u, v } => {
            let points = [*corner, *corner + *u, *corner + *v, *corner + *u + *v];
            points.into_iter().map(|p| Some([p, p])).reduce(union).flatten()
        }
        Shape::Mesh(mesh) => bounds_of_mesh(mesh),
    }
}

fn bounds_of_mesh(mesh: &Mesh) -> Option<[DVec3; 2]> {
    let corners = mesh.indices.iter().flatten().filter_map(|&index| mesh.positions.get(index as usize));
    let grow = |[low, high]: [Vec3; 2], p: &[f32; 3]| [low.min(Vec3::from(*p)), high.max(Vec3::from(*p))];
    let [low, high] = corners.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], grow);
    (low.x <= high.x).then(|| [low, high].map(|p| mesh.origin + p.as_dvec3()))
}
