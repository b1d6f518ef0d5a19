//! The immutable scene that rays flow through.

mod build;
mod distant;
mod emission_map;
mod emitters;
mod frame;
mod interiors;
mod panels;
mod parts;

pub use build::{AcceleratorSettings, SceneError};
pub use frame::FrameChanges;
pub use interiors::MAX_NESTED;
pub(crate) use interiors::{BodyStack, Interiors, Meeting, is_entering};
pub use parts::{DeltaLight, Environment, Mesh, Object, SceneParts, Shape};

use crate::{
    bsdf::{Bsdf, InLanes},
    light::{Light, LightCircle, LightContext, LightSample, LightTable, RectangleFrame, Selected},
    material::Material,
    math::{DAffine3, DVec3, Frame, Vec2, Vec3},
    spectrum::Spectrum,
    surface::{self, Chart, MeshData, NO_LIGHT, SurfacePoint},
    texture::{Lookup, Texture},
};
use emitters::{Cut, VariedLights};
use etendue_accel::{Accelerator, Hit, Place, Ray, prefetch};
use std::sync::Arc;

/// What one instance of the accelerator's world looks like: one a scene object, in the same order.
#[derive(Debug)]
pub(crate) struct Placement {
    pub primitives: Primitives,
    /// From the world without motion (relative to the scene's centre) to the object's own space, before its transform: rows.
    pub to_own: [[f32; 4]; 3],
    /// From the primitives' space to the world.
    pub place: Place,
    /// From the world without motion (relative to the scene's centre) to where the object is; the world's for what never
    /// moves.
    pub pose: Place,
    /// From the primitives' space to the object's, for what may move and is not kept as it is in the world without motion.
    inner: Option<DAffine3>,
    /// Materials of the object; at least one.
    materials: Box<[u32]>,
    /// Which of them each face has; absent: the first.
    face_materials: Option<Arc<[u32]>>,
    lights: FaceLights,
    /// True for meshes in world space without vertex normals, all of whose faces are of moderate size.
    is_flat: bool,
    /// True for flat ones of which a facet's corners and its material are all that is ever asked for.
    is_plain: bool,
}

/// The primitives of a placement, in its own space.
#[derive(Debug)]
pub(crate) enum Primitives {
    Mesh(MeshData),
    Sphere { center: Vec3, radius: f32 },
}

/// Which light each face is.
#[derive(Debug)]
enum FaceLights {
    None,
    /// All faces are one light.
    One(u32),
    /// A rectangle in columns and rows of lights.
    Grid {
        first: u32,
        cells: [u32; 2],
    },
    /// By face, the first light, [`NO_LIGHT`] where it does not emit, and how many there are along its sides; `sides` is
    /// empty if each face is one light.
    Each {
        firsts: Box<[u32]>,
        sides: Box<[u16]>,
    },
}

impl Placement {
    /// See [`MeshData::bytes`]; what placements share counts each time.
    fn mesh_bytes(&self) -> usize {
        match &self.primitives {
            Primitives::Mesh(mesh) => mesh.bytes(),
            Primitives::Sphere { .. } => 0,
        }
    }

    #[inline]
    pub fn material(&self, primitive: u32) -> u32 {
        let slot = self.face_materials.as_ref().map_or(0, |faces| faces[primitive as usize]);
        self.materials[slot as usize]
    }

    #[inline]
    pub fn light(&self, hit: &Hit) -> u32 {
        match &self.lights {
            FaceLights::None => NO_LIGHT,
            FaceLights::One(light) => *light,
            FaceLights::Grid { first, cells } => {
                let at = surface::texture_coordinates_at(self, hit.id.primitive, [hit.u, hit.v], Vec3::ZERO, 0.0);
                first + Cut::Rectangle(*cells).piece_of(at.to_array())
            }
            FaceLights::Each { firsts, sides } => {
                let first = firsts[hit.id.primitive as usize];
                match sides.get(hit.id.primitive as usize) {
                    Some(&side) if side > 1 => first + Cut::Triangle(side.into()).piece_of([hit.u, hit.v]),
                    _ => first,
                }
            }
        }
    }
}

/// How vertices on flat faces of a material are made.
#[derive(Clone, Debug)]
enum Facets {
    /// Alike everywhere, with a form for lanes, opaque and dark.
    Alike(InLanes),
    /// The same but for textures that are looked up at points.
    Textured,
    /// As those of any surface.
    Other,
}

/// How much there is in a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneStats {
    /// Objects placed.
    pub objects: u64,
    /// Triangles, each instance counted.
    pub triangles: u64,
    /// Spheres.
    pub spheres: u64,
    /// Emitters.
    pub lights: u64,
    /// Materials.
    pub materials: u64,
    /// Nodes of the accelerator.
    pub accelerator_nodes: u64,
    /// Bytes of the accelerator.
    pub accelerator_bytes: u64,
}

/// The frames of rectangles at rest whose emission has no texture, up to the last one.
fn rectangle_frames(lights: &LightTable, varied: &VariedLights) -> Vec<Option<Box<RectangleFrame>>> {
    let (table, lights) = (lights, lights.lights());
    let is_rectangle = |light: &Light| matches!(light, Light::Rectangle(_));
    let count = lights.iter().rposition(is_rectangle).map_or(0, |last| last + 1);
    let frame = |(index, light): (usize, &Light)| match light {
        Light::Rectangle(rectangle) if !varied.contains(index as u32) && !table.is_carried(index as u32) => {
            Some(RectangleFrame::of(rectangle)).filter(RectangleFrame::has_map).map(Box::new)
        }
        _ => None,
    };
    lights[..count].iter().enumerate().map(frame).collect()
}

/// An immutable scene: geometry, materials, lights and accelerator, all relative to [`Scene::center`].
pub struct Scene {
    center: DVec3,
    placements: Vec<Placement>,
    /// What it was built from, without the arrays of meshes.
    parts: SceneParts,
    /// True if anything moves while the shutter is open.
    is_moving: bool,
    /// Of materials without textures and relief.
    bsdfs: Vec<Option<Bsdf>>,
    /// Of each material.
    facets: Vec<Facets>,
    /// True if any of them is of a flat mesh and not [`Facets::Other`].
    has_plain_facets: bool,
    /// Of each material, those whose texels would have to be waited for one by one.
    far_textures: Vec<Vec<Arc<Texture>>>,
    prefetches_texels: bool,
    lights: LightTable,
    varied: VariedLights,
    rectangles: Vec<Option<Box<RectangleFrame>>>,
    interiors: Interiors,
    accelerator: Accelerator,
    opaque: bool,
    /// True if meshes have more bytes than a core's own cache.
    is_large: bool,
    filters: bool,
    has_delta_lights: bool,
    stats: SceneStats,
}

impl Scene {
    /// The point of the world that is the origin inside: the middle of the objects' bounds, metres.
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Finds hits of rays that are relative to the centre.
    pub fn accelerator(&self) -> &Accelerator {
        &self.accelerator
    }

    /// The emitters.
    pub fn lights(&self) -> &LightTable {
        &self.lights
    }

    /// A direction towards a light chosen with `u_select`, as [`LightTable::sample`], with the radiance at the sampled point
    /// where a light's emission or opacity has a texture (the lights of the table have means).
    #[inline]
    pub fn sample_light(&self, ctx: &LightContext, u_select: f64, u: [f32; 2]) -> Option<LightSample> {
        self.sample_chosen_light(ctx, self.lights.select(ctx, u_select)?, u)
    }

    /// As [`Self::sample_light`], towards a light that has been chosen.
    #[inline]
    pub fn sample_chosen_light(&self, ctx: &LightContext, chosen: Selected, u: [f32; 2]) -> Option<LightSample> {
        let sample = self.lights.sample_chosen(ctx, chosen, u)?;
        Some(self.varied.look_up(&self.placements, self.materials(), (chosen.index, ctx.time), sample))
    }

    /// What is constant about light `index`, if it is a rectangle at rest whose emission has no texture.
    #[inline]
    pub(crate) fn uniform_rectangle(&self, index: u32) -> Option<&RectangleFrame> {
        self.rectangles.get(index as usize)?.as_deref()
    }

    /// Light `index`, if it rests and its radiance has no texture.
    #[inline]
    pub(crate) fn uniform_light(&self, index: u32) -> Option<&Light> {
        let plain = |_: &&Light| !self.varied.contains(index) && !self.lights.is_carried(index);
        self.lights.lights().get(index as usize).filter(plain)
    }

    /// A direction of a circle towards a light, as [`LightTable::sample_circle`], with the radiance at the sampled point.
    #[inline(never)]
    pub fn sample_light_circle(&self, circle: &LightCircle, u_select: f64, u: [f32; 2]) -> Option<LightSample> {
        let (index, sample) = self.lights.sample_circle(circle, u_select, u)?;
        Some(self.varied.look_up(&self.placements, self.materials(), (index, 0.0), sample))
    }

    /// Radiance from outside of everything along the unit vector `wi`.
    #[inline]
    pub fn environment_radiance(&self, wi: Vec3) -> Spectrum {
        self.lights.environment_radiance(wi)
    }

    /// True if anything moves while the shutter is open.
    #[inline]
    pub fn is_moving(&self) -> bool {
        self.is_moving
    }

    /// True if no surface lets rays pass straight through.
    pub fn is_opaque(&self) -> bool {
        self.opaque
    }

    /// True if some texture looks different from afar, so that paths need a cone.
    #[inline]
    pub fn filters_textures(&self) -> bool {
        self.filters
    }

    /// True if some lights can be found by sampling only (`brute` does not see them).
    pub fn has_delta_lights(&self) -> bool {
        self.has_delta_lights
    }

    /// The objects that it was built from.
    pub(crate) fn objects(&self) -> &[Object] {
        &self.parts.objects
    }

    /// What the instances of the accelerator's world look like.
    pub(crate) fn placements(&self) -> &[Placement] {
        &self.placements
    }

    /// What fills space, and where.
    pub(crate) fn interiors(&self) -> &Interiors {
        &self.interiors
    }

    /// The materials, as given.
    pub fn materials(&self) -> &[Material] {
        &self.parts.materials
    }

    /// Scattering of material `index`, if it is the same everywhere and the material has no relief.
    #[inline]
    pub fn bsdf(&self, index: u32) -> Option<&Bsdf> {
        self.bsdfs[index as usize].as_ref()
    }

    /// True if there are facets that [`Self::plain_facet`] may take.
    pub(crate) fn has_plain_facets(&self) -> bool {
        self.has_plain_facets
    }

    /// Asks for the surfaces of hits but of plain facets, if meshes are so large that they would have to be waited for one by one: the
    /// faces of all hits first, then their corners. Likewise for their texels.
    pub(crate) fn prefetch_surfaces(&self, hits: &[Hit]) {
        if self.is_large {
            self.prefetch_corners(hits);
        }
        if self.prefetches_texels {
            self.prefetch_texels(hits);
        }
    }

    fn prefetch_texels(&self, hits: &[Hit]) {
        for hit in hits {
            let Some(placement) = self.placements.get(hit.id.instance as usize) else { continue };
            let textures = &self.far_textures[placement.material(hit.id.primitive) as usize];
            if textures.is_empty() || matches!(placement.primitives, Primitives::Sphere { .. }) {
                continue;
            }
            // Neither position nor time tells for a mesh.
            let weights = [hit.u, hit.v];
            let uv = surface::texture_coordinates_at(placement, hit.id.primitive, weights, Vec3::ZERO, 0.0);
            textures.iter().for_each(|texture| texture.prefetch(uv));
        }
    }

    fn prefetch_corners(&self, hits: &[Hit]) {
        let mesh_of = |hit: &Hit| match self.placements.get(hit.id.instance as usize)? {
            Placement { primitives: Primitives::Mesh(mesh), is_plain: false, .. } => Some(mesh),
            _ => None,
        };
        for hit in hits {
            if let Some(mesh) = mesh_of(hit) {
                prefetch(&mesh.indices[hit.id.primitive as usize]);
            }
        }
        for hit in hits {
            if let Some(mesh) = mesh_of(hit) {
                mesh.prefetch_corners(hit.id.primitive);
            }
        }
    }

    /// How the facet that was hit, with these corners, scatters, where that says all about the surface: flat, opaque, dark, and
    /// without relief. What textures tell is kept in `textured`.
    #[inline]
    pub(crate) fn plain_facet<'a>(
        &'a self,
        hit: &Hit,
        corners: &[Vec3; 3],
        textured: &'a mut Option<InLanes>,
    ) -> Option<&'a InLanes> {
        let placement = &self.placements[hit.id.instance as usize];
        if !placement.is_flat {
            return None;
        }
        match &self.facets[placement.material(hit.id.primitive) as usize] {
            Facets::Alike(bsdf) => Some(bsdf),
            Facets::Textured => {
                *textured = self.textured_facet(placement, hit, *corners);
                textured.as_ref()
            }
            Facets::Other => None,
        }
    }

    // Kept out of the loop over vertices.
    #[inline(never)]
    fn textured_facet(&self, placement: &Placement, hit: &Hit, corners: [Vec3; 3]) -> Option<InLanes> {
        let (position, ..) = surface::flat_point(corners, hit.u, hit.v);
        let at = surface::lookup(placement, hit.id.primitive, [hit.u, hit.v], position, 0.0);
        self.materials()[placement.material(hit.id.primitive) as usize].scattering.at(&at).bsdf().in_lanes()
    }

    /// The full surface point of a hit that `ray` made.
    #[inline]
    pub fn surface_point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        surface::surface_point(&self.placements[hit.id.instance as usize], ray, hit)
    }

    /// Scattering at a point, textures looked up. `surroundings` is the index of refraction around a body that has its own,
    /// else 1.
    // Kept out of the loop over vertices, most of which do without.
    #[inline(never)]
    pub fn bsdf_within(&self, point: &SurfacePoint, at: &Lookup, surroundings: f32) -> Bsdf {
        self.materials()[point.material as usize].scattering.at(at).within(surroundings).bsdf()
    }

    /// Shading normal at a hit with the relief of its material, unit length; `None` where there is no relief.
    #[inline(never)]
    pub fn detailed_normal(&self, point: &SurfacePoint, hit: &Hit, at: &Lookup) -> Option<Vec3> {
        let relief = self.materials()[point.material as usize].relief.as_ref()?;
        Some(relief.normal(point.shading_normal, at, &self.chart(point, hit)))
    }

    /// The shading frame at a hit for a BSDF that has directions, about the point's shading normal.
    #[inline(never)]
    pub fn directed_frame(&self, point: &SurfacePoint, hit: &Hit) -> Frame {
        let field = &self.materials()[point.material as usize].tangent;
        let pose = self.placements[hit.id.instance as usize].pose.at(point.time);
        let Some(pose) = pose else {
            let position = self.center + point.position.as_dvec3();
            return field.frame(position, point.shading_normal, || self.chart(point, hit), || self.lookup(point, hit));
        };
        // Fields go along with what moves: the frame is made where it would be without motion.
        let home = |v: Vec3| Vec3::from(pose.vector_to_object(v.into()));
        let position = self.center + Vec3::from(pose.point_to_object(point.position.into())).as_dvec3();
        let chart = || {
            let chart = self.chart(point, hit);
            Chart { dpdu: home(chart.dpdu), dpdv: home(chart.dpdv), ..chart }
        };
        let normal = home(point.shading_normal).normalize();
        let frame = field.frame(position, normal, chart, || self.lookup(point, hit));
        let along = Vec3::from(pose.vector_to_world(frame.s.into()));
        let within = along - point.shading_normal * along.dot(point.shading_normal);
        Frame::from_tangent(point.shading_normal, within.normalize())
    }

    /// Where textures are looked up at a hit, as a point.
    #[inline(never)]
    pub fn lookup(&self, point: &SurfacePoint, hit: &Hit) -> Lookup {
        let placement = &self.placements[hit.id.instance as usize];
        surface::lookup(placement, hit.id.primitive, [hit.u, hit.v], point.position, point.time)
    }

    /// Where textures are looked up at a hit, and over how much of the surface: what a cone about the path covers whose
    /// diameter there is `width`, metres, seen from the unit vector `wo`.
    #[inline(never)]
    pub fn lookup_over(&self, point: &SurfacePoint, hit: &Hit, wo: Vec3, width: f32) -> Lookup {
        surface::lookup_over(&self.placements[hit.id.instance as usize], point, hit, wo, width)
    }

    /// The point of the smooth surface that a mesh's vertex normals stand for, where that lies above the facet on a side, 1 or
    /// -1 (the back).
    pub(crate) fn lifted(&self, point: &SurfacePoint, hit: &Hit, side: f32) -> Option<Vec3> {
        surface::lifted(&self.placements[hit.id.instance as usize], point, hit, side)
    }

    /// Texture coordinates of a hit.
    #[inline]
    pub fn texture_coordinates(&self, point: &SurfacePoint, hit: &Hit) -> Vec2 {
        surface::texture_coordinates(&self.placements[hit.id.instance as usize], point, hit)
    }

    /// Texture coordinates of a hit with their directions.
    #[inline(never)]
    pub fn chart(&self, point: &SurfacePoint, hit: &Hit) -> Chart {
        surface::chart(&self.placements[hit.id.instance as usize], point, hit)
    }

    /// Fraction of the surface that is there, in [0, 1], at a hit.
    #[inline]
    pub fn opacity(&self, point: &SurfacePoint, hit: &Hit) -> f32 {
        let opacity = &self.materials()[point.material as usize].opacity;
        let value = match &opacity.texture {
            None => opacity.factor,
            Some(_) => opacity.at(&self.lookup(point, hit)),
        };
        value.clamp(0.0, 1.0)
    }

    /// How much there is in the scene.
    pub fn stats(&self) -> SceneStats {
        self.stats
    }
}
