//! The camera of labels: a pinhole or parallel rays, in f64.

use crate::{
    camera::{Camera, CameraError, CameraSettings, FovAxis, Projection},
    math::DVec3,
};

/// From world points to places in the image and back. A lens is taken for a pinhole in its middle.
///
/// Places are in pixels from the top left corner of the whole image, `x` to the right and `y` down; the middle of the first
/// pixel is (0.5, 0.5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    position: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Half the image's extent on the plane at unit distance (perspective) or in metres (orthographic).
    half: [f64; 2],
    size: [f64; 2],
    parallel: bool,
    near: f64,
}

/// How far points of the camera's space are from the middle of the image, in pixels: `x = fx X / Z + cx`, `y = fy Y / Z + cy`
/// with X to the right, Y down, Z along the view axis; without the division in an orthographic camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Pixels for a unit of X / Z; of X, metres, in an orthographic camera.
    pub fx: f64,
    /// The same for Y.
    pub fy: f64,
    /// Where the view axis meets the image, pixels from its left edge.
    pub cx: f64,
    /// The same from its top edge.
    pub cy: f64,
    /// True for an orthographic camera.
    pub orthographic: bool,
}

/// Which way the axes of a camera's own space point; X is to the right in both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// Y down, Z along the view: OpenCV, COLMAP.
    OpenCv,
    /// Y up, Z against the view: OpenGL, Blender, NeRF.
    OpenGl,
}

impl View {
    /// The view of a camera for an image of `resolution` pixels.
    ///
    /// # Errors
    /// As [`Camera::new`].
    pub fn new(settings: &CameraSettings, resolution: [u32; 2]) -> Result<Self, CameraError> {
        Camera::new(settings, resolution, DVec3::ZERO)?;
        let forward = settings.direction.normalize();
        let right = forward.cross(settings.up.normalize()).normalize();
        let [width, height] = resolution.map(f64::from);
        let (half, parallel) = match settings.projection {
            Projection::Perspective { fov, axis, .. } => {
                let tangent = libm::tan(0.5 * fov);
                let half = match axis {
                    FovAxis::X => [tangent, tangent * height / width],
                    FovAxis::Y => [tangent * width / height, tangent],
                };
                (half, false)
            }
            Projection::Orthographic { height: extent } => ([0.5 * extent * width / height, 0.5 * extent], true),
        };
        Ok(Self {
            position: settings.position,
            right,
            up: right.cross(forward),
            forward,
            half,
            size: [width, height],
            parallel,
            near: settings.near_clip,
        })
    }

    /// True if all rays have one direction.
    pub fn is_parallel(&self) -> bool {
        self.parallel
    }

    /// Along the view axis, unit length.
    pub fn forward(&self) -> DVec3 {
        self.forward
    }

    /// Origin (the centre of projection, or a point of the plane of projection) and unit direction of the ray through a place.
    pub fn ray(&self, [x, y]: [f64; 2]) -> (DVec3, DVec3) {
        let h = (x * (2.0 / self.size[0]) - 1.0) * self.half[0];
        let v = (1.0 - y * (2.0 / self.size[1])) * self.half[1];
        let across = self.right * h + self.up * v;
        match self.parallel {
            true => (self.position + across, self.forward),
            false => (self.position, (self.forward + across).normalize()),
        }
    }

    /// Distance of a point along the view axis, metres; negative behind the camera.
    pub fn depth(&self, point: DVec3) -> f64 {
        (point - self.position).dot(self.forward)
    }

    /// Where a point appears; `None` behind the camera.
    pub fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        let from_camera = point - self.position;
        let depth = from_camera.dot(self.forward);
        let scale = if self.parallel { 1.0 } else { depth };
        (depth > 0.0).then(|| self.place(from_camera, scale)).filter(is_finite)
    }

    /// Where something infinitely far in a direction appears; `None` behind the camera, and always where rays are parallel:
    /// there is no such place.
    pub fn project_direction(&self, direction: DVec3) -> Option<[f64; 2]> {
        let depth = direction.dot(self.forward);
        (!self.parallel && depth > 0.0).then(|| self.place(direction, depth)).filter(is_finite)
    }

    fn place(&self, v: DVec3, depth: f64) -> [f64; 2] {
        let h = v.dot(self.right) / (depth * self.half[0]);
        let v = v.dot(self.up) / (depth * self.half[1]);
        [0.5 * self.size[0] * (1.0 + h), 0.5 * self.size[1] * (1.0 - v)]
    }

    /// True inside of the whole image.
    pub fn holds(&self, [x, y]: [f64; 2]) -> bool {
        (0.0..self.size[0]).contains(&x) && (0.0..self.size[1]).contains(&y)
    }

    /// Where the ray that arrives from `point` ends: in the camera, or where rays begin.
    pub fn end_of_sight(&self, point: DVec3) -> DVec3 {
        let depth = self.depth(point);
        match self.parallel {
            true => point - self.forward * (depth - self.near),
            false => self.position + (point - self.position) * (self.near / depth),
        }
    }

    /// Distance along the view axis where rays begin, metres.
    pub fn near(&self) -> f64 {
        self.near
    }

    /// The camera's numbers.
    pub fn intrinsics(&self) -> Intrinsics {
        let [width, height] = self.size;
        let [fx, fy] = [0.5 * width / self.half[0], 0.5 * height / self.half[1]];
        Intrinsics { fx, fy, cx: 0.5 * width, cy: 0.5 * height, orthographic: self.parallel }
    }

    /// From the camera's own space to the world: rows of a 4x4 matrix that columns are multiplied with.
    pub fn to_world(&self, axes: Axes) -> [[f64; 4]; 4] {
        let [x, y, z] = self.axes(axes);
        let p = self.position;
        let row = |i: usize| [x[i], y[i], z[i], p[i]];
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
    }

    /// From the world to the camera's own space; see [`Self::to_world`].
    pub fn from_world(&self, axes: Axes) -> [[f64; 4]; 4] {
        // Adding 0 keeps negative zeros out of files.
        let row = |a: DVec3| [a.x, a.y, a.z, 0.0 - a.dot(self.position)];
        let [x, y, z] = self.axes(axes).map(row);
        [x, y, z, [0.0, 0.0, 0.0, 1.0]]
    }

    fn axes(&self, axes: Axes) -> [DVec3; 3] {
        let zero = DVec3::ZERO;
        match axes {
            Axes::OpenCv => [self.right, zero - self.up, self.forward],
            Axes::OpenGl => [self.right, self.up, zero - self.forward],
        }
        .map(|axis| axis + zero)
    }
}

fn is_finite(place: &[f64; 2]) -> bool {
    place.iter().all(|x| x.is_finite())
}
