//! Sets of rays as a path tracer makes them: from a camera, off what they meet, and towards a lamp.

use etendue_accel::{Accelerator, Hit, PrimitiveId, Ray};

use crate::mesh::Mesh;

/// A set of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Set {
    /// Through the pixels of a picture, row by row.
    Camera,
    /// Diffusely off what the camera sees, in the order of the pixels.
    Bounce,
    /// The same rays in random order.
    Shuffled,
    /// Diffusely off what the bounce rays meet.
    Second,
    /// From what the camera sees to points of a square lamp above; any hit counts.
    Shadow,
    /// The same rays in random order.
    ShadowShuffled,
}

impl Set {
    pub const ALL: [Self; 6] =
        [Self::Camera, Self::Bounce, Self::Shuffled, Self::Second, Self::Shadow, Self::ShadowShuffled];

    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Bounce => "bounce",
            Self::Shuffled => "bounce-shuffled",
            Self::Second => "second-bounce",
            Self::Shadow => "shadow",
            Self::ShadowShuffled => "shadow-shuffled",
        }
    }

    /// Whether any hit will do.
    pub fn is_any(self) -> bool {
        matches!(self, Self::Shadow | Self::ShadowShuffled)
    }
}

/// Makes sets of `count` rays each.
pub struct Maker<'a> {
    mesh: &'a Mesh,
    accelerator: &'a Accelerator,
    count: usize,
    middle: [f32; 3],
    /// Half the diagonal of the mesh's box.
    radius: f32,
    random: Random,
}

impl<'a> Maker<'a> {
    pub fn new(mesh: &'a Mesh, accelerator: &'a Accelerator, count: usize) -> Self {
        let [low, high] = mesh.bounds();
        let middle = [0, 1, 2].map(|a| 0.5 * (low[a] + high[a]));
        let radius = length([0, 1, 2].map(|a| 0.5 * (high[a] - low[a])));
        Self { mesh, accelerator, count, middle, radius, random: Random(1) }
    }

    pub fn make(&mut self, set: Set) -> Vec<Ray> {
        self.random = Random(0x9E37_79B9);
        match set {
            Set::Camera => {
                let side = (self.count as f64).sqrt().ceil() as usize;
                let mut rays = self.camera(side, 0.5, 0.5);
                rays.truncate(self.count);
                rays
            }
            Set::Bounce => self.first(),
            Set::Shuffled => {
                let rays = self.first();
                self.shuffled(rays)
            }
            Set::Second => self.second(),
            Set::Shadow => self.shadow(),
            Set::ShadowShuffled => {
                let rays = self.shadow();
                self.shuffled(rays)
            }
        }
    }

    /// From in front, above and to the right; the picture holds the mesh.
    fn camera(&self, side: usize, x: f32, y: f32) -> Vec<Ray> {
        let eye = [0, 1, 2].map(|a| self.middle[a] + 2.2 * self.radius * [0.35, 0.35, 0.87][a]);
        let forward = unit([0, 1, 2].map(|a| self.middle[a] - eye[a]));
        let right = unit(cross(forward, [0.0, 1.0, 0.0]));
        let up = cross(right, forward);
        let at = |i: usize, j: usize| {
            let (sx, sy) = (((i as f32 + x) / side as f32 - 0.5) * 0.8, (0.5 - (j as f32 + y) / side as f32) * 0.8);
            ray(eye, unit([0, 1, 2].map(|a| forward[a] + sx * right[a] + sy * up[a])), f32::INFINITY)
        };
        (0..side).flat_map(|j| (0..side).map(move |i| (i, j))).map(|(i, j)| at(i, j)).collect()
    }

    /// Points that the camera sees with their normals, in the order of the pixels, as many as are asked for.
    fn seen(&mut self) -> Vec<([f32; 3], [f32; 3])> {
        let side = (self.count as f64).sqrt().ceil() as usize;
        let probe = self.points(&self.camera(256, 0.5, 0.5)).len() as f64 / (256.0 * 256.0);
        let side = ((side as f64) / probe.max(0.01).sqrt() * 1.02).ceil() as usize;
        let mut points = self.points(&self.camera(side, 0.5, 0.5));
        points.truncate(self.count);
        points
    }

    fn first(&mut self) -> Vec<Ray> {
        let points = self.seen();
        points.into_iter().map(|(p, n)| self.diffuse(p, n)).collect()
    }

    fn second(&mut self) -> Vec<Ray> {
        let points = self.seen();
        let mut rays = Vec::new();
        for _ in 0..50 {
            let first: Vec<Ray> = points.iter().map(|&(p, n)| self.diffuse(p, n)).collect();
            rays.extend(self.points(&first).into_iter().map(|(p, n)| self.diffuse(p, n)));
            if rays.len() >= self.count {
                break;
            }
        }
        rays.truncate(self.count);
        rays
    }

    fn shadow(&mut self) -> Vec<Ray> {
        let points = self.seen();
        let towards = |(p, n): ([f32; 3], [f32; 3])| {
            let (x, z) = (self.random.next() - 0.5, self.random.next() - 0.5);
            let lamp = [0, 1, 2].map(|a| self.middle[a] + self.radius * [x, 2.0, z][a]);
            let start = [0, 1, 2].map(|a| p[a] + 1e-4 * self.radius * n[a]);
            ray(start, [0, 1, 2].map(|a| lamp[a] - start[a]), 1.0)
        };
        points.into_iter().map(towards).collect()
    }

    fn shuffled(&mut self, mut rays: Vec<Ray>) -> Vec<Ray> {
        for i in (1..rays.len()).rev() {
            rays.swap(i, self.random.below(i + 1));
        }
        rays
    }

    /// Where rays meet the mesh, with the normal towards where they come from.
    fn points(&self, rays: &[Ray]) -> Vec<([f32; 3], [f32; 3])> {
        let mut hits = vec![Hit::MISS; rays.len()];
        self.accelerator.closest_hits(rays, &mut hits);
        let point = |(ray, hit): (&Ray, &Hit)| {
            let normal = unit(self.mesh.normal(hit.id.primitive));
            let front = dot(normal, ray.direction) < 0.0;
            let normal = if front { normal } else { normal.map(|x| -x) };
            ([0, 1, 2].map(|a| ray.origin[a] + hit.t * ray.direction[a]), normal)
        };
        rays.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()).map(point).collect()
    }

    /// A direction by the cosine, from a little above the surface.
    fn diffuse(&mut self, p: [f32; 3], n: [f32; 3]) -> Ray {
        let on_sphere = loop {
            let v = [0; 3].map(|_| 2.0 * self.random.next() - 1.0);
            let square = dot(v, v);
            if square > 1e-4 && square <= 1.0 {
                break unit(v);
            }
        };
        let direction = [0, 1, 2].map(|a| on_sphere[a] + 1.0001 * n[a]);
        ray([0, 1, 2].map(|a| p[a] + 1e-4 * self.radius * n[a]), unit(direction), f32::INFINITY)
    }
}

fn ray(origin: [f32; 3], direction: [f32; 3], t_max: f32) -> Ray {
    Ray { origin, t_min: 0.0, direction, t_max, time: 0.0, mask: u32::MAX, skip: PrimitiveId::NONE }
}

/// A generator with a period long enough for a benchmark (Steele, Lea and Flood 2014, `SplitMix`).
struct Random(u64);

impl Random {
    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    /// In [0, 1).
    fn next(&mut self) -> f32 {
        (self.word() >> 40) as f32 / (1 << 24) as f32
    }

    fn below(&mut self, limit: usize) -> usize {
        ((u128::from(self.word()) * limit as u128) >> 64) as usize
    }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(a: [f32; 3]) -> f32 {
    dot(a, a).sqrt()
}

fn unit(a: [f32; 3]) -> [f32; 3] {
    let length = length(a);
    a.map(|x| x / length)
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
