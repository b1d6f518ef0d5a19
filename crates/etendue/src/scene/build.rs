//! From parts to a scene: recentred in f64, single placements baked into world space, shared shapes as instances, lights
//! listed, accelerator built.

use super::{
    FaceLights, Facets, Mesh, Object, Placement, Primitives, Scene, SceneParts, SceneStats, Shape, distant,
    emitters::{self, Listed, VariedLights},
    interiors::Interiors,
};
use crate::{
    bsdf::Bsdf,
    light::{Light, LightTable, LightTableError},
    material::Material,
    math::{DAffine3, DMat3, DVec3, Vec3},
    medium::MediumError,
    motion::Motion,
    parallel,
    surface::MeshData,
    texture::Texture,
};
use etendue_accel::{
    Accelerator, AcceleratorKind, BuildError, Geometry, Instance, Isa, Place, Sphere, Transform, TriangleMesh, World,
    zeroed_shared,
};
use std::sync::Arc;

/// Bytes of meshes, or of an image, that stay in a core's own cache, beside all else.
const CACHE: usize = 1 << 18;

/// How the accelerator is built.
#[derive(Clone, Copy, Debug)]
pub struct AcceleratorSettings {
    /// Which structure.
    pub kind: AcceleratorKind,
    /// Which instruction set its kernels use.
    pub isa: Isa,
    /// Threads for the build, at least 1.
    pub threads: usize,
}

/// Parts that make no scene.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// An index of an object is out of range.
    #[error("object `{object}` refers to {what} {index}, but there are {count}")]
    Reference {
        /// The object's name.
        object: String,
        /// What is referred to.
        what: &'static str,
        /// The index given.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A transform is singular or not finite.
    #[error("the transform of object `{0}` is singular or not finite")]
    Transform(String),
    /// A motion cannot be.
    #[error("the motion of object `{0}` {1}")]
    Motion(String, &'static str),
    /// A mesh's arrays do not fit together, or a value is not finite.
    #[error("object `{0}`: {1}")]
    Shape(String, &'static str),
    /// A material is out of range.
    #[error("material `{0}`: {1}")]
    Material(String, String),
    /// A medium has a value that is out of range.
    #[error("medium `{0}`: {1}")]
    MediumValue(String, MediumError),
    /// A light without extent has a value that is out of range; the first is 0.
    #[error("light {0}: {1}")]
    DeltaLight(usize, &'static str),
    /// The environment has a value that is out of range.
    #[error("the environment's {0}")]
    Environment(&'static str),
    /// A medium is not among those of the scene.
    #[error("{user} refers to medium `{name}`, which there is not")]
    Medium {
        /// What refers to it.
        user: String,
        /// The name given.
        name: String,
    },
    /// Too many lights.
    #[error(transparent)]
    Lights(#[from] LightTableError),
    /// The accelerator refused.
    #[error(transparent)]
    Accelerator(#[from] BuildError),
}

impl Scene {
    /// Builds a scene.
    ///
    /// # Errors
    /// When parts do not fit together or a value is out of range; see [`SceneError`].
    pub fn build(parts: SceneParts, settings: &AcceleratorSettings) -> Result<Self, SceneError> {
        validate(&parts)?;
        let center = center_of(&parts);
        let interiors = Interiors::new(&parts, center)?;
        let mut uses = vec![0usize; parts.shapes.len()];
        for object in &parts.objects {
            uses[object.shape] += 1;
        }
        let mut builder = Builder {
            parts: &parts,
            center,
            uses,
            shared: vec![None; parts.shapes.len()],
            ..Builder::default_for(&parts)
        };
        for index in 0..parts.objects.len() {
            builder.place(index)?;
        }
        let Builder { world, placements, stats, .. } = builder;
        let accelerator = Accelerator::build(&world, settings.kind, settings.isa, settings.threads)?;
        let environment = parts.environment.as_ref().and_then(distant::environment_light);
        let is_large = placements.iter().map(Placement::mesh_bytes).fold(0, usize::saturating_add) > CACHE;
        let mut scene = Self {
            center,
            is_large,
            is_moving: is_moving(&placements) || distant::is_moving(&parts.light_motions),
            placements,
            facets: Vec::new(),
            has_plain_facets: false,
            bsdfs: Vec::new(),
            far_textures: Vec::new(),
            prefetches_texels: false,
            rectangles: Vec::new(),
            lights: LightTable::default(),
            varied: VariedLights::default(),
            interiors,
            has_delta_lights: false,
            accelerator,
            opaque: true,
            filters: false,
            stats: SceneStats { objects: parts.objects.len() as u64, ..stats },
            parts: without_arrays(parts),
        };
        scene.prepare_materials();
        scene.list_lights(environment)?;
        scene.count();
        Ok(scene)
    }

    /// What is made of materials.
    pub(super) fn prepare_materials(&mut self) {
        let materials = &self.parts.materials;
        self.facets = materials.iter().map(facets).collect();
        self.has_plain_facets = false;
        for placement in self.placements.iter_mut().filter(|placement| placement.is_flat) {
            let mut facets = placement.materials.iter().map(|material| &self.facets[*material as usize]);
            self.has_plain_facets |= facets.clone().any(|facets| !matches!(facets, Facets::Other));
            placement.is_plain = facets.all(|facets| matches!(facets, Facets::Alike(_)));
        }
        self.bsdfs = materials.iter().map(plain_bsdf).collect();
        self.far_textures = materials.iter().map(far_textures).collect();
        self.prefetches_texels = self.far_textures.iter().any(|textures| !textures.is_empty());
        self.opaque = materials.iter().all(Material::is_opaque);
        self.filters = prepare_textures(materials);
    }

    /// Lists all lights; that of the environment is known.
    pub(super) fn list_lights(&mut self, environment: Option<Light>) -> Result<(), SceneError> {
        let Listed { mut lights, varied, mut carriers } = emitters::list(&self.parts, &mut self.placements);
        // Samples would be spent on light that does not arrive.
        let hides_infinity = self.interiors.hides_infinity();
        let (delta, carried) = distant::list(&self.parts, self.center, hides_infinity, lights.len())?;
        lights.extend(delta);
        carriers.extend(carried);
        lights.extend(environment.filter(|light| !(hides_infinity && light.is_infinite())));
        self.has_delta_lights = !self.parts.delta_lights.is_empty();
        self.lights = LightTable::with_carriers(lights, self.radius(), carriers)?;
        self.rectangles = super::rectangle_frames(&self.lights, &varied);
        self.varied = varied;
        Ok(())
    }

    /// Of a sphere about the centre that holds everything, metres.
    pub(super) fn radius(&self) -> f64 {
        let radius = self.accelerator.bounds().map_or(1.0, |b| {
            let corner = Vec3::from(b.min).abs().max(Vec3::from(b.max).abs());
            corner.length().max(f32::MIN_POSITIVE)
        });
        f64::from(radius)
    }

    /// Brings the numbers of what there is up to date.
    pub(super) fn count(&mut self) {
        let structure = self.accelerator.stats();
        let stats = &mut self.stats;
        stats.materials = self.parts.materials.len() as u64;
        stats.lights = self.lights.lights().len() as u64;
        stats.accelerator_nodes = structure.nodes as u64;
        stats.accelerator_bytes = structure.bytes as u64;
    }
}

/// True if anything moves while the shutter is open.
pub(super) fn is_moving(placements: &[Placement]) -> bool {
    placements.iter().any(|placement| matches!(placement.place, Place::Moving(_)))
}

/// Arrays that are in placements already, or have been brought to the world and are not needed again, are let go.
fn without_arrays(mut parts: SceneParts) -> SceneParts {
    for shape in &mut parts.shapes {
        if let Shape::Mesh(mesh) = shape {
            let (positions, indices) = ([].into(), [].into());
            *mesh = Mesh { positions, indices, normals: None, uvs: None, colors: None, face_materials: None, ..*mesh };
        }
    }
    parts
}

/// How vertices on flat faces of a material are made.
fn facets(material: &Material) -> Facets {
    if !material.is_opaque() || material.emission.is_some() || material.relief.is_some() {
        return Facets::Other;
    }
    match plain_bsdf(material) {
        Some(bsdf) => bsdf.in_lanes().map_or(Facets::Other, Facets::Alike),
        None if material.filtered_textures().iter().any(|texture| texture.is_filtered()) => Facets::Other,
        None => Facets::Textured,
    }
}

/// The textures of a material that are worth asking for ahead.
fn far_textures(material: &Material) -> Vec<Arc<Texture>> {
    material.filtered_textures().into_iter().filter(|texture| texture.unfiltered_bytes() > CACHE).collect()
}

/// The BSDF of a material that is the same everywhere.
fn plain_bsdf(material: &Material) -> Option<Bsdf> {
    let values = material.scattering.constant().filter(|_| material.relief.is_none())?;
    Some(values.bsdf())
}

/// Makes the coarser copies of images that are filtered; true if any texture is.
fn prepare_textures(materials: &[Material]) -> bool {
    let textures: Vec<_> = materials.iter().flat_map(Material::filtered_textures).collect();
    parallel::map(textures.len(), |number| textures[number].prepare());
    textures.iter().any(|texture| texture.is_filtered())
}

struct Builder<'a> {
    parts: &'a SceneParts,
    center: DVec3,
    /// How many objects place each shape.
    uses: Vec<usize>,
    /// Geometry of the shapes that are instanced, once made.
    shared: Vec<Option<u32>>,
    world: World,
    placements: Vec<Placement>,
    stats: SceneStats,
}

impl<'a> Builder<'a> {
    fn default_for(parts: &'a SceneParts) -> Self {
        Self {
            parts,
            center: DVec3::ZERO,
            uses: Vec::new(),
            shared: Vec::new(),
            world: World::default(),
            placements: Vec::new(),
            stats: SceneStats::default(),
        }
    }

    fn place(&mut self, index: usize) -> Result<(), SceneError> {
        let object = &self.parts.objects[index];
        let to_local = DAffine3::from_translation(-self.center) * object.transform;
        let (geometry, inner, primitives) = match &self.parts.shapes[object.shape] {
            Shape::Sphere { center, radius } => self.place_sphere(to_local, *center, *radius, &object.name)?,
            Shape::Rectangle { corner, u, v } => self.place_rectangle(to_local, *corner, *u, *v),
            Shape::Mesh(mesh) if self.uses[object.shape] > 1 => self.place_instance(mesh, object.shape),
            Shape::Mesh(mesh) => self.place_mesh(to_local, mesh),
        };
        let [place, pose] = match (&object.motion, inner) {
            (Some(motion), _) => places(object, motion, inner, self.center)?,
            (None, Some(inner)) => [Place::Fixed(rounded(to_local * inner, &object.name)?), Place::World],
            (None, None) => [Place::World, Place::World],
        };
        let face_materials = match &self.parts.shapes[object.shape] {
            Shape::Mesh(mesh) => mesh.face_materials.clone().filter(|_| object.materials.len() > 1),
            _ => None,
        };
        let is_flat = match &primitives {
            Primitives::Mesh(mesh) => !place.is_transformed() && mesh.is_flat(),
            Primitives::Sphere { .. } => false,
        };
        let placement = Placement {
            is_flat,
            is_plain: false,
            primitives,
            to_own: rows(to_local.inverse()),
            place: place.clone(),
            pose,
            inner: inner.filter(|_| object.motion.is_some()),
            materials: object.materials.iter().map(|m| *m as u32).collect(),
            face_materials,
            lights: FaceLights::None,
        };
        match &placement.primitives {
            Primitives::Mesh(mesh) => self.stats.triangles += mesh.indices.len() as u64,
            Primitives::Sphere { .. } => self.stats.spheres += 1,
        }
        self.world.instances.push(Instance { geometry, place, mask: u32::MAX });
        self.placements.push(placement);
        Ok(())
    }

    fn add_geometry(&mut self, geometry: Geometry) -> u32 {
        self.world.geometries.push(geometry);
        (self.world.geometries.len() - 1) as u32
    }

    fn add_mesh(&mut self, mesh: &MeshData) -> u32 {
        let (positions, indices) = (mesh.positions.clone(), mesh.indices.clone());
        self.add_geometry(Geometry::Triangles(TriangleMesh { positions, indices }))
    }

    /// A sphere stays a sphere under a similarity; else it is a unit sphere with a transform.
    fn place_sphere(
        &mut self,
        to_local: DAffine3,
        center: DVec3,
        radius: f64,
        name: &str,
    ) -> Result<(u32, Option<DAffine3>, Primitives), SceneError> {
        if let Some(scale) = similarity_scale(to_local.matrix3) {
            let center = to_local.transform_point3(center).as_vec3();
            let radius = (radius * scale) as f32;
            if !(radius > 0.0 && radius.is_finite()) {
                return Err(SceneError::Shape(name.to_owned(), "the sphere's radius is out of the range of f32"));
            }
            let spheres = Arc::new([Sphere { center: center.into(), radius }]);
            return Ok((self.add_geometry(Geometry::Spheres(spheres)), None, Primitives::Sphere { center, radius }));
        }
        let unit = DAffine3::from_scale_rotation_translation(DVec3::splat(radius), glam::DQuat::IDENTITY, center);
        let spheres = Arc::new([Sphere { center: [0.0; 3], radius: 1.0 }]);
        let geometry = self.add_geometry(Geometry::Spheres(spheres));
        let primitives = Primitives::Sphere { center: Vec3::ZERO, radius: 1.0 };
        Ok((geometry, Some(unit), primitives))
    }

    fn place_rectangle(
        &mut self,
        to_local: DAffine3,
        corner: DVec3,
        u: DVec3,
        v: DVec3,
    ) -> (u32, Option<DAffine3>, Primitives) {
        let corners = [corner, corner + u, corner + u + v, corner + v];
        let positions: Vec<_> = corners.map(|p| to_local.transform_point3(p).as_vec3().to_array()).into();
        let mesh = MeshData {
            positions: positions.into(),
            indices: Arc::new(oriented([[0, 1, 2], [0, 2, 3]], to_local.matrix3.determinant() < 0.0)),
            normals: None,
            uvs: Some(Arc::new([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])),
            colors: None,
        };
        (self.add_mesh(&mesh), None, Primitives::Mesh(mesh))
    }

    /// A mesh placed once is baked into world space.
    fn place_mesh(&mut self, to_local: DAffine3, mesh: &Mesh) -> (u32, Option<DAffine3>, Primitives) {
        let place = to_local * DAffine3::from_translation(mesh.origin);
        let placed = |p: &[f32; 3]| place.transform_point3(Vec3::from(*p).as_dvec3()).as_vec3().to_array();
        let positions = parallel::shared(zeroed_shared(mesh.positions.len()), &mesh.positions, placed);
        let mirrored = place.matrix3.determinant() < 0.0;
        let indices = match mirrored {
            true => parallel::shared(zeroed_shared(mesh.indices.len()), &mesh.indices, |&[a, b, c]| [a, c, b]),
            false => mesh.indices.clone(),
        };
        let normal_matrix = place.matrix3.inverse().transpose();
        let normals = mesh.normals.as_ref().map(|normals| {
            let to_world = |n: &[f32; 3]| {
                let n = normal_matrix * Vec3::from(*n).as_dvec3();
                n.normalize_or_zero().as_vec3().to_array()
            };
            parallel::shared(zeroed_shared(normals.len()), normals, to_world)
        });
        let (uvs, colors) = (mesh.uvs.clone(), mesh.colors.clone());
        let data = MeshData { positions, indices, normals, uvs, colors };
        (self.add_mesh(&data), None, Primitives::Mesh(data))
    }

    /// A mesh placed more than once keeps its own space.
    fn place_instance(&mut self, mesh: &Mesh, shape: usize) -> (u32, Option<DAffine3>, Primitives) {
        let data = MeshData {
            positions: mesh.positions.clone(),
            indices: mesh.indices.clone(),
            normals: mesh.normals.clone(),
            uvs: mesh.uvs.clone(),
            colors: mesh.colors.clone(),
        };
        let geometry = match self.shared[shape] {
            Some(geometry) => geometry,
            None => self.add_mesh(&data),
        };
        self.shared[shape] = Some(geometry);
        (geometry, Some(DAffine3::from_translation(mesh.origin)), Primitives::Mesh(data))
    }
}

fn oriented<const N: usize>(faces: [[u32; 3]; N], mirrored: bool) -> [[u32; 3]; N] {
    faces.map(|[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] })
}

/// The scale of a similarity (rotation, reflection and uniform scale), or `None`.
fn similarity_scale(m: DMat3) -> Option<f64> {
    let gram = m.transpose() * m;
    let squared = (gram.x_axis.x + gram.y_axis.y + gram.z_axis.z) / 3.0;
    let off = (gram - DMat3::from_diagonal(DVec3::splat(squared))).to_cols_array();
    off.iter().all(|d| d.abs() <= 1e-9 * squared).then(|| squared.sqrt())
}

fn rows(m: DAffine3) -> [[f32; 4]; 3] {
    [0, 1, 2].map(|i| {
        [m.matrix3.x_axis[i] as f32, m.matrix3.y_axis[i] as f32, m.matrix3.z_axis[i] as f32, m.translation[i] as f32]
    })
}

/// Where the primitives of something that moves are, and the pose alone. `inner` is from their space to the object's; absent
/// where they are kept as they are in the world without motion, relative to `center`.
pub(super) fn places(
    object: &Object,
    motion: &Motion,
    inner: Option<DAffine3>,
    center: DVec3,
) -> Result<[Place; 2], SceneError> {
    let wrong = |what| SceneError::Motion(object.name.clone(), what);
    motion.check().map_err(wrong)?;
    let (to_center, from_center) = (DAffine3::from_translation(-center), DAffine3::from_translation(center));
    if let Some(pose) = motion.rest() {
        let pose = pose.to_affine();
        let alone = Place::Fixed(rounded(to_center * pose * from_center, &object.name)?);
        return Ok(match inner {
            None => [alone.clone(), alone],
            // As a placement that does not move would be.
            Some(inner) => [Place::Fixed(rounded(to_center * (pose * object.transform) * inner, &object.name)?), alone],
        });
    }
    let moving = |base: DAffine3| -> Result<Place, SceneError> {
        let moving = motion.about(base, center).ok_or_else(|| wrong("has poses that are out of range"))?;
        Ok(Place::Moving(Arc::new(moving)))
    };
    let alone = moving(from_center)?;
    Ok(match inner {
        None => [alone.clone(), alone],
        Some(inner) => [moving(object.transform * inner)?, alone],
    })
}

fn rounded(m: DAffine3, name: &str) -> Result<Transform, SceneError> {
    Transform::new(rows(m)).ok_or_else(|| SceneError::Transform(name.to_owned()))
}

/// Middle of the objects' bounds; zero for an empty scene.
fn center_of(parts: &SceneParts) -> DVec3 {
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    let mut grow = |p: DVec3| {
        low = low.min(p);
        high = high.max(p);
    };
    for object in &parts.objects {
        let m = object.transform;
        match &parts.shapes[object.shape] {
            Shape::Mesh(mesh) => {
                let place = |p: &[f32; 3]| m.transform_point3(mesh.origin + Vec3::from(*p).as_dvec3());
                let [least, most] = parallel::bounds(&mesh.positions, place);
                if least.x <= most.x {
                    grow(least);
                    grow(most);
                }
            }
            Shape::Sphere { center, radius } => {
                let center = m.transform_point3(*center);
                let t = m.matrix3.transpose();
                let extent = DVec3::new(t.x_axis.length(), t.y_axis.length(), t.z_axis.length()) * *radius;
                grow(center - extent);
                grow(center + extent);
            }
            Shape::Rectangle { corner, u, v } => {
                for p in [*corner, *corner + *u, *corner + *v, *corner + *u + *v] {
                    grow(m.transform_point3(p));
                }
            }
        }
    }
    if low.x <= high.x { (low + high) * 0.5 } else { DVec3::ZERO }
}

fn validate(parts: &SceneParts) -> Result<(), SceneError> {
    parts.materials.iter().try_for_each(validate_material)?;
    for medium in &parts.media {
        medium.validate().map_err(|error| SceneError::MediumValue(medium.name.clone(), error))?;
    }
    distant::validate_delta_lights(&parts.delta_lights, &parts.light_motions)?;
    if let Some(environment) = &parts.environment {
        distant::validate_environment(environment).map_err(SceneError::Environment)?;
    }
    for object in &parts.objects {
        validate_object(parts, object)?;
    }
    Ok(())
}

pub(super) fn validate_material(material: &Material) -> Result<(), SceneError> {
    material.validate().map_err(|e| SceneError::Material(material.name.clone(), e.to_string()))
}

fn validate_object(parts: &SceneParts, object: &Object) -> Result<(), SceneError> {
    let reference = |what, index, count| SceneError::Reference { object: object.name.clone(), what, index, count };
    let shape = parts.shapes.get(object.shape).ok_or_else(|| reference("shape", object.shape, parts.shapes.len()))?;
    if object.materials.is_empty() {
        return Err(reference("material", 0, 0));
    }
    if let Some(m) = object.materials.iter().find(|m| **m >= parts.materials.len()) {
        return Err(reference("material", *m, parts.materials.len()));
    }
    let determinant = object.transform.matrix3.determinant();
    if !object.transform.is_finite() || !determinant.is_finite() || determinant == 0.0 {
        return Err(SceneError::Transform(object.name.clone()));
    }
    let wrong = |what| Err(SceneError::Shape(object.name.clone(), what));
    match shape {
        Shape::Sphere { center, radius } => {
            if !(center.is_finite() && radius.is_finite() && *radius > 0.0) {
                return wrong("a sphere needs a finite centre and a radius above 0");
            }
        }
        Shape::Rectangle { corner, u, v } => {
            if !(corner.is_finite() && u.is_finite() && v.is_finite()) || u.cross(*v).length_squared() == 0.0 {
                return wrong("a rectangle needs finite edges that are not parallel");
            }
        }
        Shape::Mesh(mesh) => return validate_mesh(mesh, object),
    }
    Ok(())
}

fn validate_mesh(mesh: &Mesh, object: &Object) -> Result<(), SceneError> {
    let wrong = |what| Err(SceneError::Shape(object.name.clone(), what));
    let vertices = mesh.positions.len();
    if parallel::any(&mesh.indices, |face| face.iter().any(|i| *i as usize >= vertices)) {
        return wrong("a face refers to a vertex that is not there");
    }
    let is_infinite = |numbers: &[f32]| numbers.iter().any(|c| !c.is_finite());
    if !mesh.origin.is_finite() || parallel::any(&mesh.positions, |p| is_infinite(p)) {
        return wrong("a vertex position is not finite");
    }
    if mesh.normals.as_ref().is_some_and(|n| n.len() != vertices || parallel::any(n, |n| is_infinite(n))) {
        return wrong("there must be one finite normal a vertex");
    }
    if mesh.uvs.as_ref().is_some_and(|t| t.len() != vertices || parallel::any(t, |t| is_infinite(t))) {
        return wrong("there must be one finite texture coordinate a vertex");
    }
    let is_no_color = |color: &[f32; 4]| color.iter().any(|c| !(0.0..=1.0).contains(c));
    if mesh.colors.as_ref().is_some_and(|c| c.len() != vertices || parallel::any(c, is_no_color)) {
        return wrong("there must be one colour a vertex, from 0 to 1");
    }
    let slots = object.materials.len() as u32;
    if let Some(faces) = &mesh.face_materials {
        if faces.len() != mesh.indices.len() {
            return wrong("there must be one material a face");
        }
        if slots > 1 && parallel::any(faces, |slot| *slot >= slots) {
            return wrong("a face has a material that the object does not have");
        }
    }
    Ok(())
}
