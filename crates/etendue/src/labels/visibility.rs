//! How much of each object is seen, of what would be seen of it were it alone.

use super::{
    LabelError, Labels, Subject, Subjects, View,
    first::Rays,
    sight::{OPAQUE, Target, met, on_threads},
};
use crate::{
    film::PixelRect,
    math::{DAffine3, DVec3, Vec3},
    scene::{Primitives, Scene},
    surface::MeshData,
};
use etendue_accel::{
    Accelerator, AcceleratorKind, BuildError, Geometry, Hit, Instance, Isa, Place, PrimitiveId, Ray, Transform,
    TriangleMesh, World,
};
use std::{
    collections::BTreeMap,
    sync::{Mutex, PoisonError},
};

/// Rows that are traced together.
const BAND: u32 = 16;
/// Faces of a mesh from which its structure is built on more than one thread.
const MANY: usize = 1 << 14;
/// Pixels about a box that what is in it may be rounded into.
const MARGIN: f64 = 2.0;

/// What the picture shows of one object. Counts are of pixels of the labelled area by their middles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Visibility {
    /// Pixels that show it.
    pub visible: u64,
    /// Pixels that would show it were it alone in the scene; at least `visible`.
    pub unoccluded: u64,
    /// The smallest box about the first, absolute pixels.
    pub visible_box: Option<PixelRect>,
    /// The same about the second.
    pub unoccluded_box: Option<PixelRect>,
}

impl Visibility {
    /// Visible over unoccluded pixels, in [0, 1]; `None` where it is outside of the picture.
    pub fn fraction(&self) -> Option<f64> {
        (self.unoccluded > 0).then(|| self.visible as f64 / self.unoccluded as f64)
    }

    fn see(&mut self, pixel: [u32; 2]) {
        self.visible += 1;
        grow(&mut self.visible_box, pixel);
        self.cover(pixel);
    }

    fn cover(&mut self, pixel: [u32; 2]) {
        self.unoccluded += 1;
        grow(&mut self.unoccluded_box, pixel);
    }

    /// Adds what was found in other pixels.
    fn add(&mut self, other: &Self) {
        self.visible += other.visible;
        self.unoccluded += other.unoccluded;
        for (own, other) in
            [(&mut self.visible_box, other.visible_box), (&mut self.unoccluded_box, other.unoccluded_box)]
        {
            let Some(PixelRect { x0, y0, x1, y1 }) = other else { continue };
            grow(own, [x0, y0]);
            grow(own, [x1 - 1, y1 - 1]);
        }
    }
}

fn grow(area: &mut Option<PixelRect>, [x, y]: [u32; 2]) {
    let pixel = PixelRect { x0: x, y0: y, x1: x + 1, y1: y + 1 };
    *area = Some(area.map_or(pixel, |a| PixelRect {
        x0: a.x0.min(x),
        y0: a.y0.min(y),
        x1: a.x1.max(x + 1),
        y1: a.y1.max(y + 1),
    }));
}

/// Structures of single geometries, by their arrays. They are kept from one frame to the next as long as they are used.
#[derive(Default)]
pub struct Outlines(BTreeMap<[usize; 2], Outline>);

struct Outline {
    structure: Accelerator,
    used: bool,
}

impl Outlines {
    fn key(mesh: &MeshData) -> [usize; 2] {
        [mesh.positions.as_ptr().addr(), mesh.indices.as_ptr().addr()]
    }

    /// Makes the structure of a mesh, if there is none. It shares the arrays, so that the key stays theirs.
    fn prepare(&mut self, mesh: &MeshData, isa: Isa, threads: usize) -> Result<(), BuildError> {
        let key = Self::key(mesh);
        if let Some(outline) = self.0.get_mut(&key) {
            outline.used = true;
            return Ok(());
        }
        let mesh = TriangleMesh { positions: mesh.positions.clone(), indices: mesh.indices.clone() };
        let threads = if mesh.indices.len() < MANY { 1 } else { threads };
        let world = World {
            geometries: vec![Geometry::Triangles(mesh)],
            instances: vec![Instance { geometry: 0, place: Place::World, mask: u32::MAX }],
        };
        let structure = Accelerator::build(&world, AcceleratorKind::Bvh, isa, threads)?;
        self.0.insert(key, Outline { structure, used: true });
        Ok(())
    }

    fn of(&self, mesh: &MeshData) -> Option<&Accelerator> {
        self.0.get(&Self::key(mesh)).map(|outline| &outline.structure)
    }

    fn forget_unused(&mut self) {
        self.0.retain(|_, outline| std::mem::take(&mut outline.used));
    }
}

/// Counts the pixels of every subject.
pub fn measure(
    labels: &Labels,
    rays: &Rays<'_>,
    subjects: &Subjects,
    outlines: &mut Outlines,
    threads: usize,
) -> Result<Vec<Visibility>, LabelError> {
    let mut counts = vec![Visibility::default(); subjects.list().len()];
    for (pixel, id) in pixels(labels.area).zip(&labels.object) {
        if let Some(subject) = (*id as usize).checked_sub(1) {
            counts[subject].see(pixel);
        }
    }
    let mut bands = Vec::new();
    for (number, subject) in subjects.list().iter().enumerate() {
        let id = number as u32 + 1;
        let Some(area) = reach(&labels.view, subject, &labels.to_world[number], labels.area) else { continue };
        let hidden = |band: &PixelRect| pixels(*band).any(|pixel| hides(labels, pixel, id));
        let mut own = bands_of(area).filter(hidden).map(|band| (number, band)).peekable();
        if own.peek().is_some() {
            for object in subject.objects[0]..subject.objects[1] {
                if let Primitives::Mesh(mesh) = &rays.scene.placements()[object].primitives {
                    outlines.prepare(mesh, rays.scene.accelerator().isa(), threads)?;
                }
            }
        }
        bands.extend(own);
    }
    let counts = Mutex::new(counts);
    on_threads(threads, bands, |(number, band)| {
        let found = count_hidden(labels, rays, &subjects.list()[number], number as u32 + 1, outlines, band);
        counts.lock().unwrap_or_else(PoisonError::into_inner)[number].add(&found);
    });
    outlines.forget_unused();
    Ok(counts.into_inner().unwrap_or_else(PoisonError::into_inner))
}

fn pixels(area: PixelRect) -> impl Iterator<Item = [u32; 2]> {
    (area.y0..area.y1).flat_map(move |y| (area.x0..area.x1).map(move |x| [x, y]))
}

fn bands_of(area: PixelRect) -> impl Iterator<Item = PixelRect> {
    let starts = (area.y0..area.y1).step_by(BAND as usize);
    starts.map(move |y0| PixelRect { y0, y1: area.y1.min(y0 + BAND), ..area })
}

/// True if a pixel shows something else than subject `id`, which may be behind that. Where nothing is seen, nothing is hidden.
fn hides(labels: &Labels, [x, y]: [u32; 2], id: u32) -> bool {
    let area = labels.area;
    let at = (y - area.y0) as usize * area.width() as usize + (x - area.x0) as usize;
    ![0, id].contains(&labels.object[at])
}

/// The pixels that a subject may cover.
fn reach(view: &View, subject: &Subject, to_world: &DAffine3, area: PixelRect) -> Option<PixelRect> {
    let [low, high] = subject.bounds?;
    let corner = |i: usize| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        to_world.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
    };
    let corners: [DVec3; 8] = std::array::from_fn(corner);
    let before = corners.iter().filter(|corner| view.depth(**corner) > view.near()).count();
    if before == 0 {
        return None;
    }
    let places: Vec<[f64; 2]> = corners.iter().filter_map(|corner| view.project(*corner)).collect();
    if before < corners.len() || places.len() < corners.len() {
        return Some(area);
    }
    let [across, down] = [0, 1].map(|axis| {
        let low = places.iter().map(|place| place[axis]).fold(f64::INFINITY, f64::min);
        let high = places.iter().map(|place| place[axis]).fold(f64::NEG_INFINITY, f64::max);
        // Numbers out of range end at the ends of the range.
        [(low - MARGIN).floor() as u32, (high + MARGIN).ceil() as u32]
    });
    let (x0, x1) = (area.x0.max(across[0]), area.x1.min(across[1]));
    let (y0, y1) = (area.y0.max(down[0]), area.y1.min(down[1]));
    (x0 < x1 && y0 < y1).then_some(PixelRect { x0, y0, x1, y1 })
}

/// The pixels of a band that a subject would cover, but for others before it.
fn count_hidden(
    labels: &Labels,
    rays: &Rays<'_>,
    subject: &Subject,
    id: u32,
    outlines: &Outlines,
    band: PixelRect,
) -> Visibility {
    let mut open: Vec<[u32; 2]> = pixels(band).filter(|pixel| hides(labels, *pixel, id)).collect();
    let mut found = Visibility::default();
    for object in subject.objects[0]..subject.objects[1] {
        let mut through: Vec<Ray> = open.iter().map(|pixel| rays.through(*pixel)).collect();
        let covered = covers(rays.scene, object as u32, outlines, &mut through);
        let mut covered = covered.into_iter();
        open.retain(|pixel| {
            let covered = covered.next().unwrap_or(false);
            if covered {
                found.cover(*pixel);
            }
            !covered
        });
    }
    found
}

/// Which rays meet an object were it alone.
fn covers(scene: &Scene, object: u32, outlines: &Outlines, rays: &mut [Ray]) -> Vec<bool> {
    let placement = &scene.placements()[object as usize];
    let transform = placement.place.at(0.0);
    let transform = transform.as_ref();
    match &placement.primitives {
        Primitives::Sphere { center, radius } => {
            rays.iter().map(|ray| meets_sphere(scene, object, (*center, *radius), transform, ray)).collect()
        }
        Primitives::Mesh(mesh) => match outlines.of(mesh) {
            Some(structure) => met(scene, Target::One { instance: object, structure, transform }, rays),
            None => vec![false; rays.len()],
        },
    }
}

fn meets_sphere(
    scene: &Scene,
    object: u32,
    (center, radius): (Vec3, f32),
    transform: Option<&Transform>,
    ray: &Ray,
) -> bool {
    let (origin, direction) = match transform {
        None => (ray.origin, ray.direction),
        Some(t) => (t.point_to_object(ray.origin), t.vector_to_object(ray.direction)),
    };
    let from_center = (Vec3::from(origin) - center).as_dvec3();
    let direction = Vec3::from(direction).as_dvec3();
    let (a, b) = (direction.length_squared(), from_center.dot(direction));
    let nearest = from_center - direction * (b / a);
    let squared = f64::from(radius) * f64::from(radius) - nearest.length_squared();
    // Where it is missed this is NaN, and nothing is above 0.
    let half = (squared / a).sqrt();
    let is_there = |t: f64| {
        let hit = Hit { t: t as f32, u: 0.0, v: 0.0, id: PrimitiveId { instance: object, primitive: 0 } };
        t > 0.0 && (scene.is_opaque() || scene.opacity(&scene.surface_point(ray, &hit), &hit) >= OPAQUE)
    };
    [-b / a - half, -b / a + half].into_iter().any(is_there)
}
