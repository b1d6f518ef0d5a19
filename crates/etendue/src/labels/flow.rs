//! Where what is seen in a frame is in another one.

use super::{
    Labels, View,
    first::{Seen, middle, on_ray},
    sight::{self, Target, met, on_threads},
};
use crate::{
    math::{DAffine3, DVec3, Vec3},
    motion::Pose,
    scene::Scene,
    surface::leave,
};
use etendue_accel::{PrimitiveId, Ray};

/// Which frame flow leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The next one.
    Forward,
    /// The previous one.
    Backward,
}

impl Way {
    /// Both, in the order of [`Labels::flow`].
    pub const ALL: [Self; 2] = [Self::Forward, Self::Backward];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Forward => "forward",
            Self::Backward => "backward",
        }
    }
}

/// Optical flow from a frame to another, from the motion of camera and bodies.
///
/// The point of the surface that the middle of a pixel shows is carried along by its object and seen by the other frame's
/// camera. Where nothing is, it is the direction that is followed, as a point at infinity.
#[derive(Clone, Debug, PartialEq)]
pub struct Flow {
    /// Place in the other frame less the place in this one, pixels, x to the right, y down. NaN where there is none: the point
    /// comes to lie behind the camera, or nothing is seen by an orthographic camera that moves.
    pub to: Vec<[f32; 2]>,
    /// 1 where the point is not visible in the other frame: hidden, outside of the image, before the plane where rays begin or
    /// behind the camera; else 0.
    pub occluded: Vec<u8>,
}

/// From the frame of some labels to another.
pub struct Path<'a> {
    labels: &'a Labels,
    scene: &'a Scene,
    view: View,
    /// What carries each object from one frame to the other; absent: it rests.
    moves: Vec<Option<DAffine3>>,
}

/// Half a unit in the last place of 1.
const EPSILON: f32 = f32::EPSILON * 0.5;

impl<'a> Path<'a> {
    pub fn new(labels: &'a Labels, scene: &'a Scene, view: View, poses: &[Pose]) -> Self {
        let between = |(from, to): (&Pose, &Pose)| (from != to).then(|| to.to_affine() * from.to_affine().inverse());
        let moves = labels.poses.iter().zip(poses).map(between).collect();
        Self { labels, scene, view, moves }
    }

    /// Fills in the flow of all pixels.
    pub fn follow(&self, flow: &mut Flow, threads: usize) {
        let area = self.labels.area;
        let width = area.width() as usize;
        let rows = flow.to.chunks_mut(width).zip(flow.occluded.chunks_mut(width)).zip(area.y0..).collect();
        on_threads(threads, rows, |((to, occluded), y)| self.follow_row(y, to, occluded));
    }

    fn follow_row(&self, y: u32, to: &mut [[f32; 2]], occluded: &mut [u8]) {
        let area = self.labels.area;
        let seen = self.labels.seen.chunks(area.width() as usize).nth((y - area.y0) as usize).unwrap_or_default();
        let (mut rays, mut pixels) = (Vec::new(), Vec::new());
        for (x, seen) in seen.iter().enumerate() {
            let pixel = [area.x0 + x as u32, y];
            let followed = match self.moves.get(seen.id.instance as usize) {
                Some(way) => self.surface(pixel, seen, way.as_ref()),
                None => self.background(pixel),
            };
            let Some(Followed { from, place, ray }) = followed else { continue };
            to[x] = [0, 1].map(|i| (place[i] - from[i]) as f32);
            if let Some(ray) = ray.filter(|_| self.view.holds(place)) {
                rays.push(ray);
                pixels.push(x);
            }
        }
        let hidden = met(self.scene, Target::All, &mut rays);
        pixels.into_iter().zip(hidden).for_each(|(x, hidden)| occluded[x] = u8::from(hidden));
    }

    /// Carries a point of a surface along.
    fn surface(&self, pixel: [u32; 2], seen: &Seen, way: Option<&DAffine3>) -> Option<Followed> {
        let center = self.scene.center();
        let met = self.labels.center + seen.position.as_dvec3();
        let exact = on_ray(&self.labels.view, pixel, met);
        let carry = |point: DVec3| way.map_or(point, |way| way.transform_point3(point));
        let normal = way.map_or(seen.normal, |way| way.transform_vector3(seen.normal.as_dvec3()).as_vec3());
        let moved = carry(exact);
        let place = self.view.project(moved)?;
        let from = self.labels.view.project(exact).unwrap_or(middle(pixel));
        let is_before = self.view.depth(moved) > self.view.near();
        let ray = is_before.then(|| {
            let start = (carry(met) - center).as_vec3();
            let end = (self.view.end_of_sight(moved) - center).as_vec3();
            // The surface is rounded anew where it has moved to, and so is the point.
            let offset = 4.0 * seen.offset + 16.0 * EPSILON * start.abs().dot(normal.abs());
            let origin = leave(start, normal, offset, end - start);
            sight::ray(origin, end - origin, 1.0, seen.id)
        });
        Some(Followed { from, place, ray })
    }

    /// Follows a direction in which nothing is.
    fn background(&self, pixel: [u32; 2]) -> Option<Followed> {
        let here = &self.labels.view;
        if *here == self.view {
            let (origin, direction) = here.ray(middle(pixel));
            return Some(Followed { from: [0.0; 2], place: [0.0; 2], ray: Some(self.outward(origin, direction)) });
        }
        let (_, direction) = here.ray(middle(pixel));
        let (from, place) = (here.project_direction(direction)?, self.view.project_direction(direction)?);
        let (origin, _) = self.view.ray(place);
        Some(Followed { from, place, ray: Some(self.outward(origin, direction)) })
    }

    /// A ray of the other camera that goes on for ever.
    fn outward(&self, origin: DVec3, direction: DVec3) -> Ray {
        let start = origin + direction * (self.view.near() / direction.dot(self.view.forward()));
        let [start, direction]: [Vec3; 2] = [start - self.scene.center(), direction].map(|v| v.as_vec3());
        sight::ray(start, direction, f32::INFINITY, PrimitiveId::NONE)
    }
}

/// Where a pixel's content is: exactly in its own frame and in the other one, and the ray between it and the other camera, if
/// it is before that.
struct Followed {
    from: [f64; 2],
    place: [f64; 2],
    ray: Option<Ray>,
}
