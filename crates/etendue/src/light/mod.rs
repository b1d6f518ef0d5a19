//! Sampling of emitters: every light by solid angle as seen from the point that gathers (flat ones from afar by area), or by projected
//! solid angle where light comes to one side of a surface, chosen from a [`LightTable`].
//!
//! Geometry is computed in f64 from f32 records, so that densities are accurate to f32 rounding for lights of any size
//! at any distance. `sample` and `pdf` share every decision as the same function of (context, light): a direction that
//! `sample` cannot draw has density 0.
//!
//! # Offsets
//!
//! A traversal in f32 finds a hit on a light's surface some rounding errors away from the true one, so a shadow ray that
//! ends on the surface may or may not be stopped by it. Targets are therefore lifted off the surface, along its normal
//! towards the context, by
//!
//! `margin = 2^-20 (C + D)`,
//!
//! C the largest magnitude of a coordinate of the context and the light's corners, D the largest magnitude of a
//! coordinate of their differences. With u = 2^-24 the unit of rounding: the point that a watertight test finds lies in
//! the light's plane, and off the ray by at most about 10 u D (the difference of vertex and origin, the shear and its
//! product, each rounded once, on two axes; the depth three times); rounding the target moves it by at most
//! sqrt(3) u C, and one affine map to an instance's space and back by some 4 u C times the map's conditioning.
//! `margin` is 16 u (C + D). A context closer than `margin` to a light's plane (or to a sphere) cannot be told from
//! a point on it, and gathers nothing from it. So the whole segment from the context to the target is on one side of
//! the plane, by at least `margin`; a sphere is on the other side of its tangent plane.

pub mod atmosphere;
mod bilinear;
mod cap;
mod carried;
mod circle;
mod directional;
mod disk;
mod elliptic_cone;
mod environment;
mod extent;
mod patch;
mod planar;
mod point;
mod polynomial;
mod projected_cone;
mod rectangle;
mod round_outline;
mod sky;
mod sphere;
mod spherical;
mod spot;
mod sun_sky;
mod table;
mod tree;
mod triangle;

pub(crate) use carried::{Carrier, LISTED_AT};
pub use circle::{Arcs, LightCircle};
pub use directional::DirectionalLight;
pub use disk::DiskLight;
pub use environment::ConstantEnvironment;
pub(crate) use environment::sample_above;
pub(crate) use planar::DrawnPoint;
pub use point::PointLightSource;
pub(crate) use rectangle::RectangleFrame;
pub use rectangle::RectangleLight;
pub use round_outline::RoundOutline;
pub use sky::{ImageEnvironment, MAX_MAP_TEXELS, RadianceMap, RadianceMapError};
pub(crate) use sphere::BallView;
pub use sphere::SphereLight;
pub use spot::SpotLight;
pub use sun_sky::SunSky;
pub use table::{LightTable, LightTableError, MAX_LIGHTS};
pub use tree::Selected;
pub use triangle::TriangleLight;
pub(crate) use triangle::TriangleView;

use crate::{
    bsdf::Density,
    math::{DVec3, Vec3},
    spectrum::Spectrum,
};
use std::sync::Arc;

/// Where light is gathered.
#[derive(Clone, Copy, Debug)]
pub struct LightContext {
    /// World space, metres.
    pub point: Vec3,
    /// Unit shading normal on the side of `wo`, or zero where there is none (media).
    pub normal: Vec3,
    /// True if light from below `normal` counts too.
    pub transmits: bool,
    /// When: shutter time in [0, 1].
    pub time: f32,
}

/// A direction towards a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit vector towards the light.
    pub wi: Vec3,
    /// The point on the light, already offset from its surface towards the context so that the segment ends before it;
    /// `None` for lights at infinity.
    pub target: Option<Vec3>,
    /// Where on the light, each in [0, 1]: weights of the second and third vertex of a triangle, multiples of the first and
    /// second edge of a rectangle; 0 for others.
    pub at: [f32; 2],
    /// Radiance that arrives if nothing is in between; for discrete lights (point, spot, directional) irradiance on a plane
    /// that faces it.
    pub radiance: Spectrum,
    /// Density of this light and direction, the choice of the light included. Finite and above 0, but up to 1e37 for
    /// tiny lights: its square may overflow.
    pub density: Density,
}

/// What each kind of light answers; densities per solid angle, without the choice of the light.
trait Emitter {
    /// See [`Light::radiance`].
    fn radiance(&self) -> Spectrum;
    /// Radiant power per unit of [`Emitter::radiance`], in m^2 sr (sr for a point or spot light, m^2 for a directional one);
    /// `scene_radius` in metres.
    /// 0 or not finite for degenerate geometry.
    fn etendue(&self, scene_radius: f64) -> f64;
    /// A direction towards the light, or `None` where the light cannot be seen.
    fn sample(&self, ctx: &LightContext, u: [f32; 2]) -> Option<LightSample>;
    /// Density with which `sample` draws the unit vector `wi`, given that a ray along it meets the light at `distance`
    /// (infinite for lights at infinity).
    fn pdf(&self, ctx: &LightContext, wi: Vec3, distance: f32) -> f32;
    /// See [`Light::arcs`].
    fn arcs(&self, _circle: &LightCircle) -> Arcs {
        Arcs::default()
    }
    /// See [`Light::reach`].
    fn reach(&self, _circle: &LightCircle, _phi: f64) -> Option<Reached> {
        None
    }
}

/// The point of a light in some direction.
#[derive(Clone, Copy, Debug)]
struct Reached {
    /// As in [`LightSample`].
    target: Vec3,
    /// As in [`LightSample`].
    at: [f32; 2],
}

/// A source of light: world space, relative to the scene's centre.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// An emissive triangle.
    Triangle(TriangleLight),
    /// An emissive parallelogram.
    Rectangle(RectangleLight),
    /// An emissive disk.
    Disk(Arc<DiskLight>),
    /// An emissive sphere or ellipsoid.
    Sphere(SphereLight),
    /// A light without extent.
    Point(PointLightSource),
    /// A light without extent that shines into a cone.
    Spot(SpotLight),
    /// Parallel light from infinity.
    Directional(DirectionalLight),
    /// The same radiance from all around.
    Environment(ConstantEnvironment),
    /// Radiance from all around by an image.
    Image(Arc<ImageEnvironment>),
    /// A sky with its sun.
    SunSky(Arc<SunSky>),
}

macro_rules! dispatch {
    ($light:expr, $inner:ident => $body:expr) => {
        match $light {
            Light::Triangle($inner) => $body,
            Light::Rectangle($inner) => $body,
            Light::Disk($inner) => $body,
            Light::Sphere($inner) => $body,
            Light::Point($inner) => $body,
            Light::Spot($inner) => $body,
            Light::Directional($inner) => $body,
            Light::Environment($inner) => $body,
            Light::Image($inner) => $body,
            Light::SunSky($inner) => $body,
        }
    };
}

impl Light {
    /// Radiance, W sr^-1 m^-2, the same in all directions, or its mean over the sphere for images and skies; for point and spot
    /// lights their (greatest) intensity, W/sr; for directional lights irradiance, W m^-2.
    #[inline]
    pub fn radiance(&self) -> Spectrum {
        dispatch!(self, light => light.radiance())
    }

    /// True for lights that no ray can meet, only light samples find: point, spot and directional lights.
    pub fn is_delta(&self) -> bool {
        matches!(self, Self::Point(_) | Self::Spot(_) | Self::Directional(_))
    }

    /// True for light from all around.
    pub fn is_environment(&self) -> bool {
        matches!(self, Self::Environment(_) | Self::Image(_) | Self::SunSky(_))
    }

    /// True for light from infinity.
    pub fn is_infinite(&self) -> bool {
        self.is_environment() || matches!(self, Self::Directional(_))
    }

    /// The middle of the light, relative to the scene's centre; `None` for light from infinity.
    #[inline]
    pub fn anchor(&self) -> Option<Vec3> {
        match self {
            Self::Triangle(light) => Some(light.vertices.into_iter().sum::<Vec3>() / 3.0),
            Self::Rectangle(light) => Some(light.corner + (light.u + light.v) * 0.5),
            Self::Disk(light) => Some(light.outline.center().as_vec3()),
            Self::Sphere(light) => Some(light.center),
            Self::Point(light) => Some(light.position),
            Self::Spot(light) => Some(light.position),
            Self::Directional(_) | Self::Environment(_) | Self::Image(_) | Self::SunSky(_) => None,
        }
    }

    /// Radiance from infinity along the unit vector `wi`; black for lights at some place or of one direction.
    #[inline]
    pub fn environment_radiance(&self, wi: Vec3) -> Spectrum {
        match self {
            Self::Environment(environment) => environment.radiance,
            Self::Image(environment) => environment.radiance_from(wi),
            Self::SunSky(environment) => environment.radiance_from(wi),
            _ => Spectrum::BLACK,
        }
    }

    /// Radiant power, W, as the mean of the channels; of light from infinity, what enters a sphere of `scene_radius` metres.
    /// 0 for lights that can never be sampled: degenerate, black, or not finite.
    pub fn power(&self, scene_radius: f64) -> f64 {
        let etendue = dispatch!(self, light => light.etendue(scene_radius));
        let power = etendue * self.radiance().0.iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0;
        if power.is_finite() && power > 0.0 { power } else { 0.0 }
    }

    /// A direction towards this light alone; its density does not include the choice of the light. `None` where the
    /// light cannot be seen (facing away, or degenerate): an estimate of 0.
    #[inline]
    pub fn sample(&self, ctx: &LightContext, u: [f32; 2]) -> Option<LightSample> {
        dispatch!(self, light => light.sample(ctx, u))
    }

    /// Density per solid angle with which [`Light::sample`] draws the unit vector `wi`, given that a ray from the
    /// context along `wi` meets the light at `distance` metres (infinite for an environment). 0 for discrete lights.
    #[inline]
    pub fn pdf(&self, ctx: &LightContext, wi: Vec3, distance: f32) -> f32 {
        dispatch!(self, light => light.pdf(ctx, wi, distance))
    }

    /// Where on a circle of directions this light is seen, nothing being in between. None for lights without extent, which no
    /// circle meets, and for those left to the lobe: light from infinity, ellipsoids seen from outside.
    #[inline]
    pub fn arcs(&self, circle: &LightCircle) -> Arcs {
        dispatch!(self, light => light.arcs(circle))
    }

    /// The light's point at an angle on one of its arcs.
    #[inline]
    fn reach(&self, circle: &LightCircle, phi: f64) -> Option<Reached> {
        dispatch!(self, light => light.reach(circle, phi))
    }

    /// True if a ray from `point` along `wi` that meets the light at `distance` metres has found what [`Self::reach`] does:
    /// not the far side of a sphere through a near side that is not there.
    #[inline]
    fn is_nearest(&self, ctx: &LightContext, wi: Vec3, distance: f32) -> bool {
        match self {
            Self::Sphere(sphere) => sphere.is_nearest(ctx, wi, distance),
            _ => true,
        }
    }
}

/// True for a unit vector, within rounding.
#[inline]
fn is_unit(v: Vec3) -> bool {
    (v.length_squared() - 1.0).abs() < 1e-5
}

/// Largest magnitude of a coordinate.
#[inline(always)]
fn max_abs(v: DVec3) -> f64 {
    v.abs().max_element()
}

/// The offset that keeps the end of a shadow ray off the light's surface: see the module's text.
#[inline(always)]
fn margin(coordinate: f64, distance: f64) -> f64 {
    const UNIT: f64 = 1.0 / 1_048_576.0;
    UNIT * (coordinate + distance)
}

/// The larger of two numbers, the second of them not NaN: `f64::max` without its care for NaN. `b` where `a` is NaN.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// `x`, or the bound that it is beyond; `low` for NaN.
#[inline(always)]
fn between(x: f64, low: f64, high: f64) -> f64 {
    let x = larger(x, low);
    if x < high { x } else { high }
}

/// A density as f32, or `None` where it is 0, not finite, or too large for later products.
#[inline]
fn finite_density(density: f64) -> Option<f32> {
    is_usable(density).then_some(density as f32)
}

/// See [`finite_density`].
#[inline(always)]
fn is_usable(density: f64) -> bool {
    (density > 1e-37) & (density < 1e37)
}
