//! Checks a world and lists what the structures are built over: the top level (untransformed primitives and transformed
//! instances together) and one bottom level per geometry that a transformed instance uses.

use rayon::prelude::*;

use crate::bounds::Bounds;
use crate::error::{BuildError, limited, room};
use crate::geometry::{Geometry, Instance, Place, Sphere, Transform, TriangleMesh, World};
use crate::local_ray::COORDINATE_LIMIT;
use crate::memory::ask_for_huge_pages;
use crate::motion::Motion;
use crate::padding::Padding;
use crate::ray::PrimitiveId;

/// What an item is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum ItemKind {
    Triangle,
    Sphere,
    /// A transformed instance; the id's primitive is 0.
    Instance,
}

/// One thing in a structure: a box in the structure's space, and an id whose halves fill the vectors up.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Item {
    /// The smallest coordinates, negated, and the bits of the id's instance, which is 0 in a bottom level; the largest
    /// coordinates, and the bits of the id's primitive. So eight maxima join two boxes.
    pub lanes: [f32; 8],
}

impl Item {
    #[inline(always)]
    pub fn new(bounds: &Bounds, id: PrimitiveId) -> Self {
        let ([a, b, c], [d, e, f]) = (bounds.min, bounds.max);
        Self { lanes: [-a, -b, -c, f32::from_bits(id.instance), d, e, f, f32::from_bits(id.primitive)] }
    }

    #[inline(always)]
    pub fn bounds(&self) -> Bounds {
        let [a, b, c, _, d, e, f, _] = self.lanes;
        Bounds { min: [-a, -b, -c], max: [d, e, f] }
    }

    #[inline(always)]
    pub fn id(&self) -> PrimitiveId {
        PrimitiveId { instance: self.lanes[3].to_bits(), primitive: self.lanes[7].to_bits() }
    }

    /// Twice the middle on an axis.
    #[inline(always)]
    pub fn middle(&self, axis: usize) -> f32 {
        self.lanes[4 + axis] - self.lanes[axis]
    }
}

/// The box around items.
pub(crate) fn bounds_of(items: &[Item]) -> Bounds {
    let part = |part: &[Item]| part.iter().fold(Bounds::EMPTY, |bounds, item| bounds.join(&item.bounds()));
    let parts: Vec<Bounds> = items.par_chunks(PART).map(part).collect();
    parts.iter().fold(Bounds::EMPTY, |a, b| a.join(b))
}

/// Items that a thread works on at once.
const PART: usize = 1 << 14;

/// A transform's scale is at most this or its reciprocal, so that directions of about unit length stay in range.
const SCALE_LIMIT: f32 = (1_u64 << 38) as f32;

impl Geometry {
    /// How many primitives.
    pub fn len(&self) -> usize {
        match self {
            Self::Triangles(mesh) => mesh.indices.len(),
            Self::Spheres(spheres) => spheres.len(),
        }
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The box around the primitives, empty if there are none.
    pub(crate) fn bounds(&self) -> Bounds {
        match self {
            Self::Triangles(mesh) => {
                let part =
                    |faces: &[[u32; 3]]| Bounds::of_points(faces.iter().flatten().map(|&i| mesh.positions[i as usize]));
                let parts: Vec<Bounds> = mesh.indices.par_chunks(PART).map(part).collect();
                parts.iter().fold(Bounds::EMPTY, |a, b| a.join(b))
            }
            Self::Spheres(spheres) => spheres.iter().map(sphere_bounds).fold(Bounds::EMPTY, |a, b| a.join(&b)),
        }
    }
}

impl TriangleMesh {
    /// The corners of a face.
    #[inline(always)]
    pub(crate) fn corners(&self, face: usize) -> [[f32; 3]; 3] {
        self.indices[face].map(|i| self.positions[i as usize])
    }
}

pub(crate) fn sphere_bounds(sphere: &Sphere) -> Bounds {
    let end = |sign: f64| sphere.center.map(|c| f64::from(c) + sign * f64::from(sphere.radius));
    Bounds::around(end(-1.0), end(1.0))
}

/// Checks everything that a user controls.
pub(crate) fn check(world: &World) -> Result<(), BuildError> {
    limited("instances", world.instances.len(), u64::from(u32::MAX) - 1)?;
    for (index, geometry) in world.geometries.iter().enumerate() {
        limited("primitives in a geometry", geometry.len(), u64::from(u32::MAX) - 1)?;
        match geometry {
            Geometry::Triangles(mesh) => check_mesh(index, mesh)?,
            Geometry::Spheres(spheres) => check_spheres(index, spheres)?,
        }
    }
    for (index, instance) in world.instances.iter().enumerate() {
        let geometries = world.geometries.len();
        if instance.geometry as usize >= geometries {
            return Err(BuildError::Geometry { instance: index, index: instance.geometry, geometries });
        }
    }
    check_places(world)
}

/// Checks where all instances are.
pub(crate) fn check_places(world: &World) -> Result<(), BuildError> {
    for (index, instance) in world.instances.iter().enumerate() {
        let checked = match &instance.place {
            Place::World => Ok(()),
            Place::Fixed(transform) => check_transform(transform),
            Place::Moving(motion) => check_motion(motion),
        };
        checked.map_err(|reason| BuildError::Transform { instance: index, reason })?;
    }
    Ok(())
}

fn in_range(x: f32) -> bool {
    x.abs() <= COORDINATE_LIMIT
}

fn check_mesh(geometry: usize, mesh: &TriangleMesh) -> Result<(), BuildError> {
    let bad = |p: &[f32; 3]| !p.iter().all(|&x| in_range(x));
    if let Some(vertex) = mesh.positions.par_iter().with_min_len(PART).position_first(bad) {
        return Err(BuildError::Position { geometry, vertex, position: mesh.positions[vertex] });
    }
    let vertices = mesh.positions.len();
    let bad = |corners: &[u32; 3]| corners.iter().any(|&i| i as usize >= vertices);
    match mesh.indices.par_iter().with_min_len(PART).position_first(bad) {
        Some(face) => {
            let index = mesh.indices[face].into_iter().find(|&i| i as usize >= vertices).unwrap_or_default();
            Err(BuildError::Index { geometry, face, index, vertices })
        }
        None => Ok(()),
    }
}

fn check_spheres(geometry: usize, spheres: &[Sphere]) -> Result<(), BuildError> {
    let fine = |s: &Sphere| s.radius > 0.0 && s.center.iter().all(|c| in_range(c.abs() + s.radius));
    match spheres.iter().position(|s| !fine(s)) {
        Some(sphere) => {
            let Sphere { center, radius } = spheres[sphere];
            Err(BuildError::Sphere { geometry, sphere, center, radius })
        }
        None => Ok(()),
    }
}

fn check_transform(transform: &Transform) -> Result<(), &'static str> {
    let expected = Transform::new(transform.to_world).ok_or("has no inverse or a number that is not finite")?;
    if expected.to_object != transform.to_object {
        return Err("does not match its inverse");
    }
    let scales = [&transform.to_world, &transform.to_object];
    if scales.iter().flat_map(|rows| rows.iter()).any(|row| row[..3].iter().any(|x| x.abs() > SCALE_LIMIT)) {
        return Err("scales by more than 2^38 or less than its reciprocal");
    }
    if scales.iter().flat_map(|rows| rows.iter()).any(|row| !in_range(row[3])) {
        return Err("moves by more than 2^50");
    }
    Ok(())
}

fn check_motion(motion: &Motion) -> Result<(), &'static str> {
    match motion.exceeds(f64::from(COORDINATE_LIMIT), f64::from(SCALE_LIMIT)) {
        false => Ok(()),
        true => Err("moves by more than 2^50, or scales by more than 2^38 or less than its reciprocal"),
    }
}

/// The items of one geometry in its own space.
pub(crate) fn of_geometry(geometry: &Geometry) -> Result<Vec<Item>, BuildError> {
    let mut items = room("items", geometry.len())?;
    ask_for_huge_pages(&mut items);
    push_primitives(geometry, 0, &mut items);
    Ok(items)
}

/// For every geometry that a transformed instance uses, its box.
pub(crate) fn object_bounds(world: &World) -> Vec<Option<Bounds>> {
    let mut used = vec![false; world.geometries.len()];
    for instance in world.instances.iter().filter(|instance| instance.place.is_transformed()) {
        used[instance.geometry as usize] = true;
    }
    world.geometries.par_iter().zip(used).map(|(geometry, used)| used.then(|| geometry.bounds())).collect()
}

/// The pad of the top level.
pub(crate) fn top_padding(world: &World, bounds: &Bounds, object_bounds: &[Option<Bounds>]) -> Padding {
    let placed = world
        .instances
        .iter()
        .filter_map(|instance| Some((&instance.place, object_bounds[instance.geometry as usize]?)));
    Padding::new(bounds, placed)
}

/// How many items the top level has, some of which may be empty.
pub(crate) fn count_of_top(world: &World) -> usize {
    let count_of = |instance: &Instance| match instance.place.is_transformed() {
        false => world.geometries[instance.geometry as usize].len(),
        true => 1,
    };
    world.instances.iter().fold(0_usize, |sum, instance| sum.saturating_add(count_of(instance)))
}

/// The world box of an object's box, at all times.
fn placed(instance: usize, place: &Place, object: Option<Bounds>) -> Result<Bounds, BuildError> {
    let object = object.unwrap_or(Bounds::EMPTY);
    let bounds = match place {
        Place::World => object,
        Place::Fixed(transform) => transform.bounds_to_world(&object),
        Place::Moving(motion) => motion.bounds_to_world(&object),
    };
    if !bounds.is_empty() && !bounds.min.iter().chain(&bounds.max).all(|&x| in_range(x)) {
        return Err(BuildError::Transform { instance, reason: "moves the geometry beyond 2^50" });
    }
    Ok(bounds)
}

/// The boxes of transformed instances in the world.
pub(crate) fn instance_bounds(
    world: &World,
    object_bounds: &[Option<Bounds>],
) -> Result<Vec<Option<Bounds>>, BuildError> {
    let of = |(index, instance): (usize, &Instance)| {
        let object = object_bounds[instance.geometry as usize];
        instance.place.is_transformed().then(|| placed(index, &instance.place, object)).transpose()
    };
    world.instances.iter().enumerate().map(of).collect()
}

/// The items of the top level.
pub(crate) fn of_top(world: &World, object_bounds: &[Option<Bounds>]) -> Result<Vec<Item>, BuildError> {
    let count = count_of_top(world);
    limited("primitives without transform", count, u64::from(u32::MAX >> 1))?;
    let mut items = room("items", count)?;
    ask_for_huge_pages(&mut items);
    for (index, instance) in world.instances.iter().enumerate() {
        let geometry = &world.geometries[instance.geometry as usize];
        match &instance.place {
            Place::World => push_primitives(geometry, index as u32, &mut items),
            _ if geometry.is_empty() => {}
            place => {
                let bounds = placed(index, place, object_bounds[instance.geometry as usize])?;
                let id = PrimitiveId { instance: index as u32, primitive: 0 };
                items.push(Item::new(&bounds, id));
            }
        }
    }
    Ok(items)
}

/// The box around the top level's items.
pub(crate) fn world_bounds(world: &World) -> Result<Bounds, BuildError> {
    let items = of_top(world, &object_bounds(world))?;
    Ok(bounds_of(&items))
}

fn push_primitives(geometry: &Geometry, instance: u32, items: &mut Vec<Item>) {
    let id = |primitive: usize| PrimitiveId { instance, primitive: primitive as u32 };
    match geometry {
        Geometry::Triangles(mesh) => {
            let item = |i: usize| Item::new(&Bounds::of_points(mesh.corners(i)), id(i));
            items.par_extend((0..mesh.indices.len()).into_par_iter().with_min_len(PART).map(item));
        }
        Geometry::Spheres(spheres) => {
            let item = |(i, sphere): (usize, &Sphere)| Item::new(&sphere_bounds(sphere), id(i));
            items.par_extend(spheres.par_iter().enumerate().with_min_len(PART).map(item));
        }
    }
}
