//! A sky with its sun, too small for the sky's map.

use super::{Emitter, ImageEnvironment, LightContext, LightSample, environment};
use crate::{
    bsdf::Density,
    math::{DVec3, Frame, Vec3, acos, sin_cos_turns, vec3},
    spectrum::Spectrum,
};
use std::f32::consts::PI;

/// Shares of the samples that the sun and the sky get at least: what is in the sun's shadow sees the sky alone.
const LEAST_SHARE: f32 = 0.125;
/// Largest random number.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON * 0.5;

/// The sun: a disk of even radiance about a direction. What is below the horizon is not there.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Disk {
    /// Towards its middle, unit length.
    axis: Vec3,
    up: Vec3,
    /// Square of the distance from the middle to the rim between unit vectors; times pi, the solid angle. Angles near
    /// 0 have no digits in their cosine, but all in this.
    chord: f32,
    radiance: Spectrum,
}

impl Disk {
    /// Solid angle, sr.
    #[inline]
    fn solid_angle(&self) -> f32 {
        PI * self.chord
    }

    #[inline]
    fn holds(&self, wi: Vec3) -> bool {
        (wi - self.axis).length_squared() <= self.chord
    }

    /// Uniform in solid angle, which is uniform in the square of the chord.
    #[inline]
    fn sample(&self, u: [f32; 2]) -> Vec3 {
        let squared = self.chord * u[0];
        let radius = (squared * (1.0 - 0.25 * squared)).max(0.0).sqrt();
        let (sin, cos) = sin_cos_turns(u[1] - 0.5);
        let local = vec3(radius * cos, radius * sin, 1.0 - 0.5 * squared);
        Frame::from_normal(self.axis).to_world(local).normalize()
    }

    /// Fraction that is above the horizon, as of a flat disk.
    fn visible(&self) -> f32 {
        let sine = self.axis.dot(self.up);
        let x = (sine / self.chord.sqrt()).clamp(-1.0, 1.0);
        1.0 - (acos(x) - x * (1.0 - x * x).sqrt()) / PI
    }
}

/// A sky by a map, and a sun that rays can meet. Both are one light: a sample is drawn from one of them, and its density is
/// that of the mixture.
#[derive(Clone, Debug, PartialEq)]
pub struct SunSky {
    sky: ImageEnvironment,
    sun: Option<Disk>,
    /// Share of the samples that the sun gets, in whole multiples of 2^-10.
    sun_share: f32,
    mean: Spectrum,
}

impl SunSky {
    /// `to_sun` points to the middle of the sun, whose `irradiance`, W m^-2, is that of the whole disk of `radius` radians,
    /// above 0 up to pi / 2, on a plane that faces it. Of the disk only what is above the horizon is there, `up` being
    /// straight up.
    pub fn new(sky: ImageEnvironment, to_sun: DVec3, up: DVec3, radius: f64, irradiance: Spectrum) -> Self {
        let half = libm::sin(0.5 * radius);
        let chord = (4.0 * half * half) as f32;
        let axis = to_sun.normalize().as_vec3();
        let disk = Disk { axis, up: up.normalize().as_vec3(), chord, radiance: Spectrum::BLACK };
        let disk = Disk { radiance: irradiance / disk.solid_angle(), ..disk };
        let visible = disk.visible();
        // Radiance within the bounds of a map's.
        let is_light = disk.radiance.0.iter().all(|c| (0.0..=1e30).contains(c)) && !irradiance.is_black();
        let sun = (visible > 0.0 && is_light).then_some(disk);
        // The mean over the sphere.
        let from_sky = sky.radiance();
        let from_sun = sun.map_or(Spectrum::BLACK, |_| irradiance * (visible / (4.0 * PI)));
        let share = match (sun.is_some(), from_sky.is_black()) {
            (false, _) => 0.0,
            (true, true) => 1.0,
            (true, false) => {
                let share = from_sun.mean() / (from_sun.mean() + from_sky.mean());
                (share.clamp(LEAST_SHARE, 1.0 - LEAST_SHARE) * 1024.0).round() / 1024.0
            }
        };
        Self { sky, sun, sun_share: share, mean: from_sky + from_sun }
    }

    /// Radiance from the direction of the unit vector `wi`.
    #[inline]
    pub fn radiance_from(&self, wi: Vec3) -> Spectrum {
        let sky = self.sky.radiance_from(wi);
        match &self.sun {
            Some(sun) if sun.holds(wi) && wi.dot(sun.up) > 0.0 => sky + sun.radiance,
            _ => sky,
        }
    }

    #[inline]
    fn density(&self, ctx: &LightContext, wi: Vec3) -> f32 {
        let sky = (1.0 - self.sun_share) * self.sky.pdf(ctx, wi, f32::INFINITY);
        match &self.sun {
            Some(sun) if sun.holds(wi) => sky + self.sun_share / sun.solid_angle(),
            _ => sky,
        }
    }
}

impl Emitter for SunSky {
    #[inline]
    fn radiance(&self) -> Spectrum {
        self.mean
    }

    fn etendue(&self, scene_radius: f64) -> f64 {
        environment::etendue(scene_radius)
    }

    /// `u[0]` chooses between sun and sky, and is used again.
    #[inline]
    fn sample(&self, ctx: &LightContext, [u, v]: [f32; 2]) -> Option<LightSample> {
        let share = self.sun_share;
        let wi = match &self.sun {
            Some(sun) if u < share => sun.sample([(u / share).min(BELOW_ONE), v]),
            _ => self.sky.sample(ctx, [((u - share) / (1.0 - share)).clamp(0.0, BELOW_ONE), v])?.wi,
        };
        // By the direction, rounded as it is, so that this is what a ray along it finds.
        let density = self.density(ctx, wi);
        (density > 0.0).then(|| LightSample {
            wi,
            at: [0.0; 2],
            target: None,
            radiance: self.radiance_from(wi),
            density: Density::SolidAngle(density),
        })
    }

    #[inline]
    fn pdf(&self, ctx: &LightContext, wi: Vec3, _distance: f32) -> f32 {
        self.density(ctx, wi)
    }
}
