//! Where textures are looked up, and over how much of the surface.

use crate::{
    bsdf::Density,
    math::{Vec2, Vec3, vec2},
};

/// A cone about a path's ray: how much of a surface one path stands for (Amanatides, "Ray Tracing with Cones", 1984;
/// Akenine-Möller et al., "Texture Level of Detail Strategies for Real-Time Ray Tracing", 2019).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayCone {
    /// Diameter where the ray begins, metres.
    pub width: f32,
    /// Growth of the diameter with the distance, metres per metre.
    pub spread: f32,
}

/// Samples that share a lobe: scattering widens a cone by the part of the lobe that one of so many stands for.
const SAMPLES_A_LOBE: f32 = 16.0;
/// Widest that one scattering makes a cone, radians: that of a diffuse surface.
const WIDEST: f32 = 0.5;

impl RayCone {
    /// The cone `distance` further along the ray, metres.
    #[inline]
    pub fn advanced(self, distance: f32) -> Self {
        Self { width: self.width + self.spread * distance, ..self }
    }

    /// The cone after a direction was drawn with `density`: a solid angle of `1 / (16 density)` wider, as large as what
    /// one of 16 samples of the lobe stands for (with the idea of path differentials: Suykens and Willems 2001). Discrete
    /// directions keep the cone as it is.
    #[inline]
    pub fn scattered(self, density: Density) -> Self {
        let Density::SolidAngle(pdf) = density else { return self };
        // pi (angle / 2)^2 is the solid angle of a narrow cone.
        let angle = (4.0 / (std::f32::consts::PI * SAMPLES_A_LOBE * pdf)).sqrt();
        Self { spread: self.spread + angle.min(WIDEST), ..self }
    }
}

/// The part of a surface that a lookup stands for: an ellipse, by its two whole axes. All zero is a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// In texture coordinates.
    pub uv: [Vec2; 2],
    /// In the object's own space, metres.
    pub position: [Vec3; 2],
}

/// Where a texture is looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lookup {
    /// Texture coordinates.
    pub uv: Vec2,
    /// In the object's own space, before its transform, metres: solid textures go with the object.
    pub position: Vec3,
    /// Change of `position` for a unit of u and of v; zero where it is not known.
    pub tangents: [Vec3; 2],
    /// The mesh's colour there, linear, with its opacity; white where it has none.
    pub color: [f32; 4],
    /// What the value is a mean over, as well as the texture can tell.
    pub footprint: Footprint,
}

impl Lookup {
    /// At a point, white, with nothing known but its coordinates.
    pub fn new(uv: Vec2, position: Vec3) -> Self {
        Self { uv, position, tangents: [Vec3::ZERO; 2], color: [1.0; 4], footprint: Footprint::default() }
    }

    /// The same a little further along u and v.
    #[inline]
    pub fn moved(&self, by: Vec2) -> Self {
        let [along_u, along_v] = self.tangents;
        Self { uv: self.uv + by, position: self.position + along_u * by.x + along_v * by.y, ..*self }
    }

    /// Whole extent of the footprint along u and v.
    #[inline]
    pub fn uv_extent(&self) -> Vec2 {
        let [a, b] = self.footprint.uv;
        vec2((a.x * a.x + b.x * b.x).sqrt(), (a.y * a.y + b.y * b.y).sqrt())
    }
}

impl From<Vec2> for Lookup {
    fn from(uv: Vec2) -> Self {
        Self::new(uv, Vec3::ZERO)
    }
}
