//! What a model is like, as far as a picture of it depends on that: one pass over its faces.

use crate::mesh_file::{MeshFile, Sphere};
use etendue::{math::DMat3, spectrum::Spectrum};
use glam::DVec3;
use std::f64::consts::PI;

/// How near to a side of the bounding box a face counts as part of that side, of the box's extent.
const SLAB: f64 = 0.04;

/// A mesh file's geometry as it stands in the scene.
pub struct Model<'a> {
    file: &'a MeshFile,
    placement: DMat3,
    /// Vertices that faces use, if not all are used: strays do not count.
    used: Option<Vec<u32>>,
}

/// Sums over faces, spheres included.
#[derive(Clone, Copy, Debug, Default)]
pub struct Survey {
    /// Lowest and highest corner of the bounding box.
    pub bounds: [DVec3; 2],
    /// Area of all.
    pub area: f64,
    /// Area-weighted sum of the faces' normals.
    pub facing: DVec3,
    /// Of what emits: area times radiance (mean of the channels).
    pub emitted: f64,
    /// Centre of what emits, weighted alike.
    pub emitter: DVec3,
    /// Share of each side of the bounding box that faces lie along: low x, y, z, high x, y, z.
    pub covered: [f64; 6],
}

impl<'a> Model<'a> {
    /// The geometry of `file` after `placement`.
    pub fn new(file: &'a MeshFile, placement: DMat3) -> Self {
        let mut is_used = vec![false; file.mesh.positions.len()];
        for &corner in file.mesh.indices.iter().flatten() {
            is_used[corner as usize] = true;
        }
        let some_stray = is_used.contains(&false);
        let used = || (0u32..).zip(&is_used).filter(|(_, used)| **used).map(|(i, _)| i).collect();
        Self { file, placement, used: some_stray.then(used) }
    }

    /// The same, larger by a factor.
    pub fn scaled(self, factor: f64) -> Self {
        Self { placement: self.placement * factor, ..self }
    }

    fn point(&self, index: u32) -> DVec3 {
        let position = self.file.mesh.positions[index as usize].map(f64::from);
        self.placement * (self.file.mesh.origin + DVec3::from_array(position))
    }

    /// The scale of the placement, which is uniform.
    fn scale(&self) -> f64 {
        self.placement.x_axis.length()
    }

    fn spheres(&self) -> impl Iterator<Item = Sphere> + '_ {
        self.file.spheres.iter().map(|s| Sphere {
            center: self.placement * s.center,
            radius: s.radius * self.scale(),
            ..*s
        })
    }

    /// The largest product of each vector with a point of the model; -inf where there is none.
    pub fn reach<const N: usize>(&self, vectors: &[DVec3; N]) -> [f64; N] {
        let mut most = [f64::NEG_INFINITY; N];
        let mut see = |point: DVec3| {
            for (most, vector) in most.iter_mut().zip(vectors) {
                *most = most.max(vector.dot(point));
            }
        };
        match &self.used {
            Some(used) => used.iter().for_each(|&i| see(self.point(i))),
            None => (0..self.file.mesh.positions.len() as u32).for_each(|i| see(self.point(i))),
        }
        for sphere in self.spheres() {
            for (most, vector) in most.iter_mut().zip(vectors) {
                *most = most.max(vector.dot(sphere.center) + sphere.radius * vector.length());
            }
        }
        most
    }

    /// Looks at every face and sphere. `own_materials`: emission counts.
    pub fn survey(&self, own_materials: bool) -> Survey {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
        let [x, y, z, low_x, low_y, low_z] = self.reach(&axes);
        let bounds = [DVec3::new(-low_x, -low_y, -low_z), DVec3::new(x, y, z)];
        let radiance: Vec<f64> = self.file.materials.iter().map(|m| mean_radiance(&m.material.emission)).collect();
        let radiance = |material: u32| match own_materials {
            true => radiance.get(material as usize).copied().unwrap_or(0.0),
            false => 0.0,
        };
        let mut sums = Sums::new(bounds);
        let mesh = &self.file.mesh;
        for (index, face) in mesh.indices.iter().enumerate() {
            let material = mesh.face_materials.as_ref().map_or(0, |m| m[index]);
            sums.face(face.map(|i| self.point(i)), radiance(material));
        }
        for sphere in self.spheres() {
            sums.emit(sphere.center, 4.0 * PI * sphere.radius * sphere.radius, radiance(sphere.material));
        }
        sums.survey()
    }
}

/// Mean of the channels; of a textured emission half, as nobody has looked at the image.
fn mean_radiance<T>(emission: &Option<etendue::material::Emission<T>>) -> f64 {
    let Some(emission) = emission else { return 0.0 };
    let Spectrum(rgb) = emission.radiance.factor;
    let mean = rgb.iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0;
    if emission.radiance.texture.is_some() { 0.5 * mean } else { mean }
}

struct Sums {
    survey: Survey,
    slab: DVec3,
}

impl Sums {
    fn new(bounds: [DVec3; 2]) -> Self {
        let survey = Survey { bounds, ..Survey::default() };
        Self { survey, slab: (bounds[1] - bounds[0]) * SLAB }
    }

    fn face(&mut self, corners: [DVec3; 3], radiance: f64) {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a) * 0.5;
        self.survey.facing += normal;
        self.emit((a + b + c) / 3.0, normal.length(), radiance);
        let [low, high] = [a.min(b).min(c), a.max(b).max(c)];
        let at_low = high.cmplt(self.survey.bounds[0] + self.slab);
        let at_high = low.cmpgt(self.survey.bounds[1] - self.slab);
        for axis in 0..3 {
            for (side, there) in [(axis, at_low.test(axis)), (axis + 3, at_high.test(axis))] {
                if there {
                    self.survey.covered[side] += normal[axis].abs();
                }
            }
        }
    }

    fn emit(&mut self, center: DVec3, area: f64, radiance: f64) {
        self.survey.area += area;
        self.survey.emitted += area * radiance;
        self.survey.emitter += center * (area * radiance);
    }

    fn survey(mut self) -> Survey {
        let size = self.survey.size();
        for axis in 0..3 {
            let side = size[(axis + 1) % 3] * size[(axis + 2) % 3];
            for side_index in [axis, axis + 3] {
                let covered = &mut self.survey.covered[side_index];
                *covered = if side > 0.0 { *covered / side } else { 0.0 };
            }
        }
        if self.survey.emitted > 0.0 {
            self.survey.emitter /= self.survey.emitted;
        }
        self.survey
    }
}

impl Survey {
    /// Extents of the bounding box.
    pub fn size(&self) -> DVec3 {
        self.bounds[1] - self.bounds[0]
    }

    /// Middle of the bounding box.
    pub fn center(&self) -> DVec3 {
        (self.bounds[0] + self.bounds[1]) * 0.5
    }

    /// The normal of a model that is flat, away from its front.
    pub fn flat(&self, model: &Model) -> Option<DVec3> {
        const THIN: f64 = 1e-3;
        let size = self.size();
        let longest = size.max_element();
        let facing = if self.facing.length() > 0.1 * self.area { self.facing.try_normalize() } else { None };
        if let Some(normal) = facing {
            let [front, back] = model.reach(&[normal, -normal]);
            if front + back < THIN * longest {
                return Some(normal);
            }
        }
        // Two layers back to back, such as a sheet of paper with both its sides.
        [DVec3::Z, DVec3::X, DVec3::Y].into_iter().find(|axis| axis.dot(size) < THIN * longest)
    }
}
