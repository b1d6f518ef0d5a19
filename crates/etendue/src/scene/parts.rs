//! All that a scene is built from: plain records with f64 transforms.

use crate::{
    light::{RadianceMap, atmosphere::Atmosphere},
    material::Material,
    math::{DAffine3, DMat3, DVec3},
    medium::Medium,
    motion::Motion,
    spectrum::Spectrum,
};
use std::sync::Arc;

/// A triangle mesh as it was read: flat arrays, shared.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Added in f64 to every position: keeps meshes far from their origin precise.
    pub origin: DVec3,
    /// Vertex positions relative to `origin`.
    pub positions: Arc<[[f32; 3]]>,
    /// Three vertex indices a face.
    pub indices: Arc<[[u32; 3]]>,
    /// Unit normals, one a vertex; absent: flat shading.
    pub normals: Option<Arc<[[f32; 3]]>>,
    /// Texture coordinates, one a vertex.
    pub uvs: Option<Arc<[[f32; 2]]>>,
    /// Colours, linear, with their opacity, each in [0, 1], one a vertex; for textures of
    /// [vertex colours](crate::texture::Pattern::VertexColor).
    pub colors: Option<Arc<[[f32; 4]]>>,
    /// Index into [`Object::materials`], one a face; absent: all 0.
    pub face_materials: Option<Arc<[u32]>>,
}

/// Geometry that objects place.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Triangles.
    Mesh(Mesh),
    /// An analytic sphere.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius, above 0.
        radius: f64,
    },
    /// A parallelogram `corner + a u + b v`, u, v in [0, 1], with normal along `u` x `v`; sampled by solid angle where
    /// it is a rectangle.
    Rectangle {
        /// The corner with texture coordinates (0, 0).
        corner: DVec3,
        /// Edge to texture coordinates (1, 0).
        u: DVec3,
        /// Edge to texture coordinates (0, 1).
        v: DVec3,
    },
}

/// A shape placed in the world. Objects that share a shape are instances of it.
#[derive(Clone, Debug)]
pub struct Object {
    /// As in the scene file.
    pub name: String,
    /// Index into [`SceneParts::shapes`].
    pub shape: usize,
    /// Object to world, metres.
    pub transform: DAffine3,
    /// Indices into [`SceneParts::materials`], at least one; a face picks by [`Mesh::face_materials`].
    pub materials: Vec<usize>,
    /// For what moves at some time, now or in another frame: its poses while the shutter is open, `world = pose(time) *
    /// transform`. Such an object keeps its place in the renderer's structures when it moves on, see
    /// [`Scene::with_frame`](super::Scene::with_frame). Absent: it never moves. Textures and directions of grooves go along;
    /// media with varying density do not: these stay where they are in the world.
    pub motion: Option<Motion>,
}

/// A light that no ray can meet: without extent, or of one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeltaLight {
    /// Shines alike in all directions.
    Point {
        /// World space, metres.
        position: DVec3,
        /// Radiant intensity, W/sr.
        intensity: Spectrum,
    },
    /// Shines into a cone; see [`SpotLight`](crate::light::SpotLight).
    Spot {
        /// World space, metres.
        position: DVec3,
        /// Where it points, of any length but 0.
        direction: DVec3,
        /// Half angle of the cone, radians, above 0 up to pi.
        half_angle: f64,
        /// Share of the half angle, from the rim inwards, where the light fades, in [0, 1].
        blend: f64,
        /// Radiant intensity on the axis, W/sr.
        intensity: Spectrum,
    },
    /// Parallel light from infinity.
    Directional {
        /// Where the light travels to, of any length but 0.
        direction: DVec3,
        /// W m^-2 on a plane that faces it.
        irradiance: Spectrum,
    },
}

/// Light from all around.
#[derive(Clone, Debug)]
pub enum Environment {
    /// The same radiance from every direction, W sr^-1 m^-2.
    Constant(Spectrum),
    /// By an equirectangular image; see [`ImageEnvironment`](crate::light::ImageEnvironment).
    Image {
        /// The image.
        map: Arc<RadianceMap>,
        /// A rotation, from the image's space (y up, +z in the middle) to the world.
        orientation: DMat3,
        /// Multiplies the image.
        strength: Spectrum,
    },
    /// A clear sky, computed; see [`atmosphere`](crate::light::atmosphere).
    Sky {
        /// Towards the sun, of any length but 0.
        sun: DVec3,
        /// Straight up, of any length but 0.
        up: DVec3,
        /// The air and the ground.
        atmosphere: Atmosphere,
        /// Multiplies all light.
        strength: Spectrum,
        /// Half of the angle that the sun is seen under, radians, above 0 up to pi / 2; its irradiance does not depend on it.
        sun_radius: f64,
        /// False leaves the disk of the sun out, but not the light that it gives to sky and ground.
        sun_disk: bool,
    },
}

impl From<Spectrum> for Environment {
    fn from(radiance: Spectrum) -> Self {
        Self::Constant(radiance)
    }
}

/// All that a scene is built from.
#[derive(Clone, Debug, Default)]
pub struct SceneParts {
    /// Shared geometry.
    pub shapes: Vec<Shape>,
    /// Placements.
    pub objects: Vec<Object>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Lights that no ray can meet.
    pub delta_lights: Vec<DeltaLight>,
    /// Motions of some of them while the shutter is open, by ascending index: `world = pose(time) * light`.
    pub light_motions: Vec<(usize, Motion)>,
    /// Light from all around; absent: black.
    pub environment: Option<Environment>,
    /// What bodies and the world may be filled with; each name once.
    pub media: Vec<Medium>,
    /// Name of the medium that fills all space outside of bodies; absent: nothing does.
    pub world_medium: Option<String>,
}
