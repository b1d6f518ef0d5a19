//! What the ray through the middle of each pixel meets first.

use super::{
    LabelError, LabelSettings, Labels, Moment, Subjects, View,
    sight::{self, Target, first_surfaces, on_threads},
};
use crate::{
    camera::{Camera, CameraSettings, Projection},
    math::{DVec3, Vec3},
    scene::Scene,
    surface::SurfacePoint,
};
use etendue_accel::{Hit, PrimitiveId, Ray};
use std::slice::ChunksMut;

/// What flow needs of a surface that was met.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Relative to the scene's centre.
    pub position: Vec3,
    /// Unit length, geometric.
    pub normal: Vec3,
    /// See [`SurfacePoint::offset`].
    pub offset: f32,
    pub id: PrimitiveId,
}

impl Seen {
    pub const NOTHING: Self = Self { position: Vec3::ZERO, normal: Vec3::ZERO, offset: 0.0, id: PrimitiveId::NONE };
}

/// The rays through the middles of pixels.
pub struct Rays<'a> {
    pub scene: &'a Scene,
    camera: Camera,
}

impl<'a> Rays<'a> {
    pub fn new(moment: &Moment<'a>, settings: &LabelSettings) -> Result<Self, LabelError> {
        let camera = Camera::new(&pinhole(moment.camera), settings.resolution, moment.scene.center())?;
        Ok(Self { scene: moment.scene, camera })
    }

    /// Through the middle of an absolute pixel.
    pub fn through(&self, [x, y]: [u32; 2]) -> Ray {
        let ray = self.camera.ray(x as f32 + 0.5, y as f32 + 0.5, [0.5; 2]);
        sight::ray(ray.origin, ray.direction, f32::INFINITY, PrimitiveId::NONE)
    }
}

/// The camera with its lens closed to a point.
fn pinhole(camera: &CameraSettings) -> CameraSettings {
    let mut pinhole = *camera;
    if let Projection::Perspective { lens_radius, .. } = &mut pinhole.projection {
        *lens_radius = 0.0;
    }
    pinhole
}

/// The middle of an absolute pixel.
pub fn middle([x, y]: [u32; 2]) -> [f64; 2] {
    [f64::from(x) + 0.5, f64::from(y) + 0.5]
}

/// The point of a pixel's exact ray that a surface point, world space, which its rounded ray met stands for.
pub fn on_ray(view: &View, pixel: [u32; 2], point: DVec3) -> DVec3 {
    let (origin, direction) = view.ray(middle(pixel));
    origin + direction * (point - origin).dot(direction)
}

/// A row of labels that is being made; those that are not asked for are empty.
struct Row<'a> {
    y: u32,
    object: &'a mut [u32],
    material: &'a mut [u32],
    face: &'a mut [u32],
    depth: &'a mut [f32],
    normal: &'a mut [[f32; 3]],
    position: &'a mut [[f32; 3]],
    albedo: &'a mut [[f32; 3]],
    seen: &'a mut [Seen],
}

/// Traces the rays and fills in what they meet.
pub fn fill(labels: &mut Labels, rays: &Rays<'_>, subjects: &Subjects, threads: usize) {
    let (view, x0) = (labels.view, labels.area.x0);
    on_threads(threads, rows(labels), |row| row.fill(rays, &view, subjects, x0));
}

fn rows(labels: &mut Labels) -> Vec<Row<'_>> {
    fn next<'a, T>(rows: &mut ChunksMut<'a, T>) -> &'a mut [T] {
        rows.next().unwrap_or_default()
    }
    let (area, width) = (labels.area, labels.area.width() as usize);
    let (mut object, mut material) = (labels.object.chunks_mut(width), labels.material.chunks_mut(width));
    let (mut face, mut depth) = (labels.face.chunks_mut(width), labels.depth.chunks_mut(width));
    let (mut normal, mut position) = (labels.normal.chunks_mut(width), labels.position.chunks_mut(width));
    let (mut albedo, mut seen) = (labels.albedo.chunks_mut(width), labels.seen.chunks_mut(width));
    let row = |y| Row {
        y,
        object: next(&mut object),
        material: next(&mut material),
        face: next(&mut face),
        depth: next(&mut depth),
        normal: next(&mut normal),
        position: next(&mut position),
        albedo: next(&mut albedo),
        seen: next(&mut seen),
    };
    (area.y0..area.y1).map(row).collect()
}

impl Row<'_> {
    fn fill(self, rays: &Rays<'_>, view: &View, subjects: &Subjects, x0: u32) {
        let first: Vec<Ray> = (0..self.object.len() as u32).map(|x| rays.through([x0 + x, self.y])).collect();
        let (mut last, mut hits) = (first.clone(), vec![Hit::MISS; first.len()]);
        first_surfaces(rays.scene, Target::All, &mut last, &mut hits);
        for (x, hit) in hits.iter().enumerate().filter(|(_, hit)| hit.is_hit()) {
            let point = rays.scene.surface_point(&last[x], hit);
            let world = on_ray(view, [x0 + x as u32, self.y], rays.scene.center() + point.position.as_dvec3());
            let toward = Vec3::from(first[x].direction);
            self.object[x] = subjects.id(hit.id.instance);
            set(self.material, x, point.material + 1);
            set(self.face, x, hit.id.primitive + 1);
            set(self.depth, x, view.depth(world) as f32);
            set(self.normal, x, facing(&point, toward).to_array());
            set(self.position, x, world.as_vec3().to_array());
            set(
                self.seen,
                x,
                Seen { position: point.position, normal: point.geometric_normal, offset: point.offset, id: hit.id },
            );
            if let Some(albedo) = self.albedo.get_mut(x) {
                let distance = (point.position - Vec3::from(first[x].origin)).dot(toward);
                let width = rays.camera.cone(toward).advanced(distance).width;
                *albedo = self::albedo(rays.scene, &point, hit, -toward, width);
            }
        }
    }
}

fn set<T>(row: &mut [T], x: usize, value: T) {
    if let Some(place) = row.get_mut(x) {
        *place = value;
    }
}

/// The shading normal on the side that is seen along `toward`.
fn facing(point: &SurfacePoint, toward: Vec3) -> Vec3 {
    if point.geometric_normal.dot(toward) > 0.0 { -point.shading_normal } else { point.shading_normal }
}

fn albedo(scene: &Scene, point: &SurfacePoint, hit: &Hit, wo: Vec3, width: f32) -> [f32; 3] {
    if let Some(bsdf) = scene.bsdf(point.material) {
        return bsdf.albedo().0;
    }
    let at = match scene.filters_textures() {
        true => scene.lookup_over(point, hit, wo, width),
        false => scene.lookup(point, hit),
    };
    scene.bsdf_within(point, &at, 1.0).albedo().0
}
