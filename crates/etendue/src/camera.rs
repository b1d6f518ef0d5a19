//! Cameras: from a point on the image and a point on the lens to a ray.

use crate::{
    math::{DVec3, Vec2, Vec3},
    sampling::warp,
    texture::RayCone,
};
use std::f64::consts::PI;

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
    origin: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Half the image's extent on the plane at unit distance (perspective) or in metres (orthographic).
    half: Vec2,
    /// Image coordinates to [-1, 1].
    scale: Vec2,
    lens: Option<Lens>,
    parallel: bool,
    near_clip: f32,
}

#[derive(Clone, Debug)]
struct Lens {
    opening: Opening,
    focus: f32,
}

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
        let [width, height] = resolution.map(f64::from);
        let (half, lens) = match s.projection {
            Projection::Perspective { fov, axis, lens_radius, aperture, focus_distance } => {
                if !(fov > 0.0 && fov < PI) {
                    return Err(CameraError::FieldOfView(fov.to_degrees()));
                }
                if !(lens_radius >= 0.0 && lens_radius.is_finite()) {
                    return Err(CameraError::Range("the lens radius", "at least 0"));
                }
                if !(focus_distance > 0.0 && focus_distance.is_finite()) {
                    return Err(CameraError::Range("the focus distance", "above 0"));
                }
                let tangent = libm::tan(0.5 * fov);
                let half = match axis {
                    FovAxis::X => [tangent, tangent * height / width],
                    FovAxis::Y => [tangent * width / height, tangent],
                };
                let lens = Lens { opening: Opening::new(aperture, lens_radius)?, focus: focus_distance as f32 };
                (half, (lens_radius > 0.0).then_some(lens))
            }
            Projection::Orthographic { height: extent } => {
                if !(extent > 0.0 && extent.is_finite()) {
                    return Err(CameraError::Range("the height of an orthographic camera", "above 0"));
                }
                ([0.5 * extent * width / height, 0.5 * extent], None)
            }
        };
        Ok(Self {
            origin: (s.position - center).as_vec3(),
            right: right.as_vec3(),
            up: up.as_vec3(),
            forward: forward.as_vec3(),
            half: Vec2::new(half[0] as f32, half[1] as f32),
            scale: Vec2::new((2.0 / width) as f32, (2.0 / height) as f32),
            lens,
            parallel: matches!(s.projection, Projection::Orthographic { .. }),
            near_clip: s.near_clip as f32,
        })
    }

    /// The ray through the image point (`x` to the right, `y` down, pixels from the top left corner) and the lens point
    /// that `u` in [0, 1)^2 picks.
    #[inline]
    pub fn ray(&self, x: f32, y: f32, u: [f32; 2]) -> CameraRay {
        let ray = self.whole_ray(x, y, u);
        if self.near_clip == 0.0 {
            return ray;
        }
        CameraRay { origin: ray.origin + ray.direction * self.clipped(ray.direction), ..ray }
    }

    /// How much of a ray in `direction` lies before the plane where rays begin, metres.
    #[inline]
    fn clipped(&self, direction: Vec3) -> f32 {
        self.near_clip / direction.dot(self.forward)
    }

    /// A ray from the lens or the plane of projection.
    #[inline]
    fn whole_ray(&self, x: f32, y: f32, u: [f32; 2]) -> CameraRay {
        let h = (x * self.scale.x - 1.0) * self.half.x;
        let v = (1.0 - y * self.scale.y) * self.half.y;
        if self.parallel {
            return CameraRay { origin: self.origin + self.right * h + self.up * v, direction: self.forward };
        }
        let Some(lens) = &self.lens else {
            let direction = self.forward + self.right * h + self.up * v;
            return CameraRay { origin: self.origin, direction: direction.normalize() };
        };
        let on_lens = lens.opening.sample(u);
        // The point in focus stays where it is; the ray starts elsewhere on the lens.
        let (dx, dy) = (h * lens.focus - on_lens.x, v * lens.focus - on_lens.y);
        let direction = self.forward * lens.focus + self.right * dx + self.up * dy;
        CameraRay {
            origin: self.origin + self.right * on_lens.x + self.up * on_lens.y,
            direction: direction.normalize(),
        }
    }

    /// The centre of projection, relative to the scene's centre; of an orthographic camera the middle of its image.
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// The middle of the plane where rays begin, relative to the scene's centre.
    pub fn start(&self) -> Vec3 {
        self.origin + self.forward * self.near_clip
    }

    /// The cone of a pixel about a ray in `direction`, from where it begins: where the ray meets a plane that faces the camera, it is as wide as
    /// the pixel there.
    #[inline]
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

    /// True if rays depend on the lens point.
    pub fn has_lens(&self) -> bool {
        self.lens.is_some()
    }

    /// Distance of `point` (relative to the scene's centre) along the view axis, metres.
    #[inline]
    pub fn depth(&self, point: Vec3) -> f32 {
        (point - self.origin).dot(self.forward)
    }
}
