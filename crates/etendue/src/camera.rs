//! Cameras: from a point on the image and a point on the lens to a ray.

use crate::{
    math::{DMat3, DQuat, DVec3, Vec2, Vec3},
    motion::Pose,
    sampling::warp,
    texture::RayCone,
};
use std::{f64::consts::PI, sync::Arc};

/// Which side of the image the field of view spans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FovAxis {
    /// The width.
    X,
    /// The height.
    Y,
}

/// The opening of a lens. All have the area of the round one, so they blur equally much.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Aperture {
    /// A disk.
    #[default]
    Round,
    /// A square with its sides along those of the image, then turned.
    Square {
        /// Radians, counter-clockwise in the image of a far light.
        rotation: f64,
    },
    /// A regular polygon with a corner up, then turned: an iris of so many blades.
    Polygon {
        /// 3 to [`MAX_BLADES`].
        blades: u32,
        /// Radians, counter-clockwise in the image of a far light.
        rotation: f64,
    },
}

/// Most blades of an [`Aperture::Polygon`].
pub const MAX_BLADES: u32 = 64;

/// How points of the image become rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A pinhole or a thin lens.
    Perspective {
        /// Field of view across the whole image, radians, in (0, pi).
        fov: f64,
        /// The side that `fov` spans.
        axis: FovAxis,
        /// Radius of the round lens, metres; 0 is a pinhole.
        lens_radius: f64,
        /// The lens's shape.
        aperture: Aperture,
        /// Distance of the plane in focus along the view axis, metres, above 0.
        focus_distance: f64,
    },
    /// Parallel rays.
    Orthographic {
        /// Height of the whole image in the scene, metres, above 0.
        height: f64,
    },
}

/// A camera in world space, f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraSettings {
    /// Centre of projection, metres.
    pub position: DVec3,
    /// Where it looks; any length but 0.
    pub direction: DVec3,
    /// Up in the image; not parallel to `direction`.
    pub up: DVec3,
    /// How points of the image become rays.
    pub projection: Projection,
    /// Distance along the view axis of the plane on which rays begin, metres, at least 0: nothing nearer is seen, nor does a
    /// medium begin before it.
    pub near_clip: f64,
}

/// A camera on its way while the shutter is open: between two keys the position goes straight, the orientation turns at constant
/// speed the shorter way, field of view, focus and the other numbers change evenly.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraMotion {
    /// Shutter times in [0, 1], strictly ascending, the first 0 and the last 1, each with its camera: all of one projection
    /// and aperture.
    pub keys: Arc<[(f64, CameraSettings)]>,
}

/// A camera that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// A component is NaN or infinite.
    #[error("the camera has a value that is not finite")]
    NotFinite,
    /// Zero direction.
    #[error("the camera's direction is zero")]
    NoDirection,
    /// Up gives no roll.
    #[error("the camera's up vector is zero or parallel to its direction")]
    UpParallel,
    /// Out of (0, 180) degrees.
    #[error("the field of view is {0} degrees; it must be above 0 and below 180")]
    FieldOfView(f64),
    /// Lens or image plane without extent.
    #[error("{0} must be {1}")]
    Range(&'static str, &'static str),
    /// Keys of a moving camera that do not fit together.
    #[error("the camera's motion {0}")]
    Motion(&'static str),
    /// Blades of an aperture out of range.
    #[error("an aperture of {0} blades; it must have from 3 to {MAX_BLADES}")]
    Blades(u32),
}

/// A ray from the camera: world space relative to the scene's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraRay {
    /// Origin, metres.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
}

/// A camera ready to make rays.
#[derive(Clone, Debug)]
pub struct Camera {
    /// At time 0.
    view: View,
    opening: Option<Opening>,
    /// Its kind is that of all keys.
    kind: Projection,
    /// Pixels across and down.
    image: [f64; 2],
    /// Of a camera that moves.
    stages: Box<[Stage]>,
}

/// A camera at one time, but for the shape of its lens.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    origin: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Half the image's extent on the plane at unit distance (perspective) or in metres (orthographic).
    half: Vec2,
    /// Image coordinates to [-1, 1].
    scale: Vec2,
    /// Distance of what is in focus.
    focus: f32,
    /// Multiplies points of the lens.
    aperture: f32,
    parallel: bool,
    near_clip: f32,
}

/// A key of a camera that moves.
#[derive(Clone, Copy, Debug)]
struct Stage {
    time: f64,
    /// Turns the x, y and negative z axes to right, up and forward; the shift is relative to the scene's centre.
    pose: Pose,
    /// See [`Numbers`].
    numbers: Numbers,
}

/// What changes evenly: field of view in radians or height of the image, focus distance, lens radius, and distance where rays
/// begin, in metres.
type Numbers = [f64; 4];

/// The points of a lens, metres along the camera's right and up.
#[derive(Clone, Debug)]
enum Opening {
    Disk(f32),
    /// Half of the edges.
    Square(Vec2),
    /// Corners, the first again at the end.
    Polygon(Box<[Vec2]>),
}

impl Opening {
    fn new(aperture: Aperture, radius: f64) -> Result<Self, CameraError> {
        let corner = |length: f64, angle: f64| {
            let (sin, cos) = libm::sincos(angle);
            Vec2::new((length * cos) as f32, (length * sin) as f32)
        };
        let rotation = match aperture {
            Aperture::Round => 0.0,
            Aperture::Square { rotation } | Aperture::Polygon { rotation, .. } => rotation,
        };
        if !rotation.is_finite() {
            return Err(CameraError::NotFinite);
        }
        Ok(match aperture {
            Aperture::Round => Self::Disk(radius as f32),
            Aperture::Square { .. } => Self::Square(corner(0.5 * libm::sqrt(PI) * radius, rotation)),
            Aperture::Polygon { blades: 3..=MAX_BLADES, .. } if radius <= 0.0 => Self::Disk(radius as f32),
            Aperture::Polygon { blades: blades @ 3..=MAX_BLADES, .. } => {
                let step = 2.0 * PI / f64::from(blades);
                let to_corner = radius * libm::sqrt(step / libm::sin(step));
                let at = |i: u32| corner(to_corner, rotation + 0.5 * PI + f64::from(i % blades) * step);
                Self::Polygon((0..=blades).map(at).collect())
            }
            Aperture::Polygon { blades, .. } => return Err(CameraError::Blades(blades)),
        })
    }

    /// Uniform over the area.
    #[inline]
    fn sample(&self, u: [f32; 2]) -> Vec2 {
        match self {
            Self::Disk(radius) => warp::disk(u) * *radius,
            Self::Square(half) => {
                let [x, y] = u.map(|u| 2.0 * u - 1.0);
                *half * x + half.perp() * y
            }
            Self::Polygon(corners) => {
                let blades = corners.len() - 1;
                let place = u[0] * blades as f32;
                // Rounding may reach the number itself.
                let blade = (place as usize).min(blades - 1);
                let [a, b, _] = warp::triangle([(place - blade as f32).min(1.0), u[1]]);
                corners[blade] * a + corners[blade + 1] * b
            }
        }
    }
}

impl Camera {
    /// Prepares `settings` for an image of `resolution` pixels and a scene whose centre is `center`.
    ///
    /// # Errors
    /// When a value is out of its range.
    pub fn new(settings: &CameraSettings, resolution: [u32; 2], center: DVec3) -> Result<Self, CameraError> {
        let s = settings;
        if !(s.position.is_finite() && s.direction.is_finite() && s.up.is_finite()) {
            return Err(CameraError::NotFinite);
        }
        if !(s.near_clip >= 0.0 && s.near_clip.is_finite()) {
            return Err(CameraError::Range("the distance where rays begin", "at least 0"));
        }
        let forward = s.direction.try_normalize().ok_or(CameraError::NoDirection)?;
        let up = s.up.try_normalize().ok_or(CameraError::UpParallel)?;
        let right = forward.cross(up);
        if right.length() < 1e-9 {
            return Err(CameraError::UpParallel);
        }
        let right = right.normalize();
        let up = right.cross(forward);
        let (numbers, opening) = match s.projection {
            Projection::Perspective { fov, lens_radius, aperture, focus_distance, .. } => {
                if !(fov > 0.0 && fov < PI) {
                    return Err(CameraError::FieldOfView(fov.to_degrees()));
                }
                if !(lens_radius >= 0.0 && lens_radius.is_finite()) {
                    return Err(CameraError::Range("the lens radius", "at least 0"));
                }
                if !(focus_distance > 0.0 && focus_distance.is_finite()) {
                    return Err(CameraError::Range("the focus distance", "above 0"));
                }
                let opening = Opening::new(aperture, lens_radius)?;
                ([fov, focus_distance, 1.0, s.near_clip], (lens_radius > 0.0).then_some(opening))
            }
            Projection::Orthographic { height: extent } => {
                if !(extent > 0.0 && extent.is_finite()) {
                    return Err(CameraError::Range("the height of an orthographic camera", "above 0"));
                }
                ([extent, 1.0, 1.0, s.near_clip], None)
            }
        };
        let axes = DMat3::from_cols(right, up, -forward);
        let image = resolution.map(f64::from);
        let view = View::new(s.position - center, axes, numbers, s.projection, image);
        Ok(Self { view, opening, kind: s.projection, image, stages: Box::default() })
    }

    /// Prepares a camera that moves.
    ///
    /// # Errors
    /// When a value of a key is out of its range, or the keys do not fit together.
    pub fn moving(motion: &CameraMotion, resolution: [u32; 2], center: DVec3) -> Result<Self, CameraError> {
        let keys = &motion.keys;
        let (Some(&(first, settings)), Some(&(last, _))) = (keys.first(), keys.last()) else {
            return Err(CameraError::Motion("has no keys"));
        };
        let mut camera = Self::new(&settings, resolution, center)?;
        if keys.iter().all(|(_, other)| *other == settings) {
            return Ok(camera);
        }
        if !(first == 0.0 && last == 1.0 && keys.windows(2).all(|pair| pair[0].0 < pair[1].0)) {
            return Err(CameraError::Motion("has times that do not ascend from 0 to 1"));
        }
        let mut stages = Vec::with_capacity(keys.len());
        for (time, key) in keys.iter() {
            let view = Self::new(key, resolution, center)?.view;
            if !is_alike(&key.projection, &settings.projection) {
                return Err(CameraError::Motion("changes its kind of projection or aperture"));
            }
            let [right, up, forward] = [view.right, view.up, view.forward].map(|v| v.as_dvec3().normalize());
            let rotation = DQuat::from_mat3(&DMat3::from_cols(right, up, -forward)).normalize();
            let pose = Pose { rotation, translation: key.position - center };
            let numbers = match key.projection {
                Projection::Perspective { fov, lens_radius, focus_distance, .. } => {
                    [fov, focus_distance, lens_radius, key.near_clip]
                }
                Projection::Orthographic { height } => [height, 1.0, 0.0, key.near_clip],
            };
            stages.push(Stage { time: *time, pose, numbers });
        }
        camera.opening = match settings.projection {
            Projection::Perspective { aperture, .. } if stages.iter().any(|stage| stage.numbers[2] > 0.0) => {
                Some(Opening::new(aperture, 1.0)?)
            }
            _ => None,
        };
        camera.stages = stages.into();
        Ok(camera)
    }

    /// True if it moves while the shutter is open.
    pub fn is_moving(&self) -> bool {
        !self.stages.is_empty()
    }

    /// The camera at a shutter time in [0, 1].
    #[inline]
    pub(crate) fn view(&self, time: f32) -> View {
        if self.stages.is_empty() { self.view } else { self.view_between(f64::from(time)) }
    }

    #[inline(never)]
    fn view_between(&self, time: f64) -> View {
        let next = self.stages.partition_point(|stage| stage.time <= time).clamp(1, self.stages.len() - 1);
        let (a, b) = (&self.stages[next - 1], &self.stages[next]);
        let share = ((time - a.time) / (b.time - a.time)).clamp(0.0, 1.0);
        let Pose { rotation, translation } = a.pose.between(b.pose, share);
        let numbers = std::array::from_fn(|i| a.numbers[i] + (b.numbers[i] - a.numbers[i]) * share);
        View::new(translation, DMat3::from_quat(rotation), numbers, self.kind, self.image)
    }

    /// The ray through the image point (`x` to the right, `y` down, pixels from the top left corner) and the lens point
    /// that `u` in [0, 1)^2 picks.
    #[inline]
    pub fn ray(&self, x: f32, y: f32, u: [f32; 2]) -> CameraRay {
        self.ray_in(&self.view, x, y, u)
    }

    /// As [`Self::ray`], in one of the camera's views.
    #[inline]
    pub(crate) fn ray_in(&self, view: &View, x: f32, y: f32, u: [f32; 2]) -> CameraRay {
        let on_lens = self.opening.as_ref().map(|opening| opening.sample(u));
        view.ray(x, y, on_lens)
    }

    /// The centre of projection, relative to the scene's centre; of an orthographic camera the middle of its image.
    pub fn origin(&self) -> Vec3 {
        self.view.origin
    }

    /// The middle of the plane where rays begin, relative to the scene's centre.
    pub fn start(&self) -> Vec3 {
        self.view.start()
    }

    /// See [`RayCone`]: the cone of a pixel about a ray in `direction`.
    #[inline]
    pub fn cone(&self, direction: Vec3) -> RayCone {
        self.view.cone(direction)
    }

    /// True if rays depend on the lens point.
    pub fn has_lens(&self) -> bool {
        self.opening.is_some()
    }

    /// Distance of `point` (relative to the scene's centre) along the view axis, metres.
    #[inline]
    pub fn depth(&self, point: Vec3) -> f32 {
        self.view.depth(point)
    }
}

/// True if one camera may become the other.
fn is_alike(a: &Projection, b: &Projection) -> bool {
    match (a, b) {
        (
            Projection::Perspective { axis: a, aperture: of_a, .. },
            Projection::Perspective { axis: b, aperture: of_b, .. },
        ) => a == b && of_a == of_b,
        (Projection::Orthographic { .. }, Projection::Orthographic { .. }) => true,
        _ => false,
    }
}

impl View {
    /// A view from a point relative to the scene's centre, along axes to the right, up and back, through an image of a kind of
    /// projection; `image` is its size in pixels. All in range.
    fn new(origin: DVec3, axes: DMat3, numbers: Numbers, projection: Projection, image: [f64; 2]) -> Self {
        let [extent, focus, aperture, near_clip] = numbers;
        let [width, height] = image;
        let half = match projection {
            Projection::Perspective { axis, .. } => {
                let tangent = libm::tan(0.5 * extent);
                match axis {
                    FovAxis::X => [tangent, tangent * height / width],
                    FovAxis::Y => [tangent * width / height, tangent],
                }
            }
            Projection::Orthographic { .. } => [0.5 * extent * width / height, 0.5 * extent],
        };
        Self {
            origin: origin.as_vec3(),
            right: axes.x_axis.as_vec3(),
            up: axes.y_axis.as_vec3(),
            forward: -axes.z_axis.as_vec3(),
            half: Vec2::new(half[0] as f32, half[1] as f32),
            scale: Vec2::new((2.0 / width) as f32, (2.0 / height) as f32),
            focus: focus as f32,
            aperture: aperture as f32,
            parallel: matches!(projection, Projection::Orthographic { .. }),
            near_clip: near_clip as f32,
        }
    }

    /// How much of a ray in `direction` lies before the plane where rays begin, metres.
    #[inline]
    fn clipped(&self, direction: Vec3) -> f32 {
        self.near_clip / direction.dot(self.forward)
    }

    /// True for an orthographic camera, whose rays are all parallel.
    pub fn is_parallel(&self) -> bool {
        self.parallel
    }

    /// The same view, of which the caller knows whether it is parallel.
    #[inline(always)]
    pub fn told(self, parallel: bool) -> Self {
        Self { parallel, ..self }
    }

    /// A ray from where it begins, of a point of the lens or of a pinhole.
    #[inline(always)]
    pub fn ray(&self, x: f32, y: f32, on_lens: Option<Vec2>) -> CameraRay {
        let ray = self.whole_ray(x, y, on_lens);
        if self.near_clip == 0.0 {
            return ray;
        }
        CameraRay { origin: ray.origin + ray.direction * self.clipped(ray.direction), ..ray }
    }

    /// A ray from a point of the lens or the plane of projection.
    #[inline(always)]
    fn whole_ray(&self, x: f32, y: f32, on_lens: Option<Vec2>) -> CameraRay {
        let h = (x * self.scale.x - 1.0) * self.half.x;
        let v = (1.0 - y * self.scale.y) * self.half.y;
        if self.parallel {
            return CameraRay { origin: self.origin + self.right * h + self.up * v, direction: self.forward };
        }
        let Some(on_lens) = on_lens else {
            let direction = self.forward + self.right * h + self.up * v;
            return CameraRay { origin: self.origin, direction: direction.normalize() };
        };
        let on_lens = on_lens * self.aperture;
        // The point in focus stays where it is; the ray starts elsewhere on the lens.
        let (dx, dy) = (h * self.focus - on_lens.x, v * self.focus - on_lens.y);
        let direction = self.forward * self.focus + self.right * dx + self.up * dy;
        CameraRay {
            origin: self.origin + self.right * on_lens.x + self.up * on_lens.y,
            direction: direction.normalize(),
        }
    }

    /// The middle of the plane where rays begin, relative to the scene's centre.
    pub fn start(&self) -> Vec3 {
        self.origin + self.forward * self.near_clip
    }

    /// The cone of a pixel about a ray in `direction`, from where it begins: where the ray meets a plane that faces the camera, it is as wide as
    /// the pixel there.
    #[inline(always)]
    pub fn cone(&self, direction: Vec3) -> RayCone {
        // Pixels are squares.
        let pixel = self.half.y * self.scale.y;
        match self.parallel {
            true => RayCone { width: pixel, spread: 0.0 },
            false => {
                let spread = pixel * direction.dot(self.forward);
                RayCone { width: spread * self.clipped(direction), spread }
            }
        }
    }

    /// Distance of `point` (relative to the scene's centre) along the view axis, metres.
    #[inline]
    pub fn depth(&self, point: Vec3) -> f32 {
        (point - self.origin).dot(self.forward)
    }
}
