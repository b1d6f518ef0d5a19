//! From a description to what the renderer takes: mesh files loaded, names resolved, transforms composed.

mod ahead;
mod bodies;
mod environment;
mod meshes;
mod sky;
pub(crate) mod textures;
mod view;
mod volumes;

use crate::{
    Diagnostic, Diagnostics, Limits, Severity, SourceMap,
    description::{Located, ObjectRecord, SceneDescription, ShapeRecord, Step},
    geometry,
    import::{Import, LoadedTexture},
    mesh_file::MeshFile,
};
pub(crate) use environment::environment_at;
use etendue::{
    camera::CameraSettings,
    film::FilmSettings,
    integrator::Integrator,
    material::{Color, Scattering},
    math::{DAffine3, DVec3},
    sampling::{Filter, Sampler},
    scene::{Object, SceneParts, Shape},
    spectrum::Spectrum,
    texture::{Pattern, Texture},
    tonemap::DisplayTransform,
};
use etendue_accel::AcceleratorKind;
pub(crate) use meshes::unknown_ending;
use meshes::{Geometry, Loader, Piece, Treatment};
use sha2::{Digest, Sha256};
use std::{collections::BTreeMap, ops::Range, path::PathBuf, sync::Arc};
pub(crate) use view::{bounds, camera, middle};

/// Everything a render needs.
#[derive(Clone, Debug)]
pub struct Input {
    /// Geometry, materials, lights.
    pub parts: SceneParts,
    /// Of each object of the description, in order, what it is among `parts.objects`: a mesh file's mesh and spheres are one each.
    pub placed: Vec<Range<usize>>,
    /// The view.
    pub camera: CameraSettings,
    /// Size, crop and layers of the picture.
    pub film: FilmSettings,
    /// Reconstruction filter.
    pub filter: Filter,
    /// How the picture becomes 8 bits.
    pub display: DisplayTransform,
    /// Where random numbers come from.
    pub sampler: Sampler,
    /// Samples per pixel.
    pub spp: u32,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Estimator of radiance.
    pub integrator: Integrator,
    /// Most edges of a path, the camera segment included.
    pub max_depth: Option<u32>,
    /// Parts of a sample; absent: chosen.
    pub splitting: Option<u32>,
    /// Ray traversal.
    pub accelerator: AcceleratorKind,
    /// SHA-256 of all files read, see [`scene_hash`].
    pub scene_hash: [u8; 32],
    /// The files read, in order.
    pub files: Vec<PathBuf>,
    /// What came of each mesh file, in order; more than once of one that is smoothed in several ways.
    pub imports: Vec<Import>,
    /// The images of textures, by path.
    pub textures: Vec<LoadedTexture>,
    /// Warnings and notes; no errors.
    pub findings: Diagnostics,
}

/// SHA-256 over the files of a source map in the order of reading: of each its length (8 bytes, little-endian) and its
/// [digest](SourceMap::digest).
pub fn scene_hash(sources: &SourceMap) -> [u8; 32] {
    let mut hash = Sha256::new();
    for (id, digest) in sources.ids().zip(sources.digests()) {
        hash.update((sources.length(id) as u64).to_le_bytes());
        hash.update(digest);
    }
    hash.finalize().into()
}

/// Loads the files that a description names, each once, and resolves it. Settings that a command line overrides are to be
/// changed in the description before.
///
/// # Errors
/// All findings, if there is an error among them: files that cannot be read, unknown names, limits that are passed.
pub fn build(description: &SceneDescription, sources: &mut SourceMap, limits: &Limits) -> Result<Input, Diagnostics> {
    build_with(description, sources, limits, BTreeMap::new())
}

/// [`build`], with mesh files that have been read from `sources` already, by their paths.
///
/// # Errors
/// As [`build`].
pub fn build_with(
    description: &SceneDescription,
    sources: &mut SourceMap,
    limits: &Limits,
    loaded: BTreeMap<PathBuf, MeshFile>,
) -> Result<Input, Diagnostics> {
    let mut loaded = loaded;
    loaded.append(&mut ahead::read_ahead(description, sources, limits, &loaded));
    let mut builder = Builder::new(description, sources, limits, loaded);
    let mut placed = Vec::with_capacity(description.objects.len());
    for (number, object) in description.objects.iter().enumerate() {
        let first = builder.parts.objects.len();
        builder.place(number, object);
        placed.push(first..builder.parts.objects.len());
    }
    let camera = camera(&description.camera, description.film.size, &builder.parts, None);
    let media = builder.loader.media();
    let environment = description.environment.as_ref().and_then(|record| builder.loader.environment(record));
    let Builder { mut parts, loader, .. } = builder;
    let Loader { mut findings, imports, textures, .. } = loader;
    let camera = match camera {
        Ok(camera) if !findings.has_errors() => camera,
        camera => {
            camera.err().into_iter().for_each(|error| findings.push(error));
            findings.sort();
            return Err(findings);
        }
    };
    findings.sort();
    parts.delta_lights = description.lights.iter().map(|light| light.value).collect();
    parts.environment = environment;
    parts.media = media;
    parts.world_medium = description.world_medium.as_ref().map(|name| name.value.clone());
    let film = &description.film;
    Ok(Input {
        parts,
        placed,
        camera,
        film: FilmSettings {
            resolution: film.size,
            crop: film.crop.as_ref().map(|crop| crop.value),
            aovs: film.aovs.clone(),
            transparent: film.transparent,
        },
        filter: film.filter,
        display: film.display,
        sampler: description.sampler.sampler,
        spp: description.sampler.spp,
        seed: description.sampler.seed,
        integrator: description.integrator.integrator,
        max_depth: description.integrator.depth,
        splitting: description.integrator.splitting,
        accelerator: description.accelerator,
        scene_hash: scene_hash(sources),
        files: sources.ids().map(|id| sources.path(id).to_owned()).collect(),
        imports,
        textures: textures.images().collect(),
        findings,
    })
}

/// Numbers of a shape that objects may share, as bits.
type ShapeKey = (&'static str, Vec<u64>);

struct Builder<'a> {
    parts: SceneParts,
    loader: Loader<'a>,
    materials: BTreeMap<&'a str, usize>,
    default_material: Option<usize>,
    colored_material: Option<usize>,
    shared: BTreeMap<ShapeKey, usize>,
    relocated: usize,
    closed: bodies::Closed,
    limits: &'a Limits,
}

impl<'a> Builder<'a> {
    fn new(
        description: &'a SceneDescription,
        sources: &'a mut SourceMap,
        limits: &'a Limits,
        loaded: BTreeMap<PathBuf, MeshFile>,
    ) -> Self {
        let materials = &description.materials;
        let mut builder = Self {
            parts: SceneParts::default(),
            loader: Loader::new(description, sources, limits, loaded),
            materials: materials.iter().enumerate().map(|(i, m)| (m.material.name.as_str(), i)).collect(),
            default_material: None,
            colored_material: None,
            shared: BTreeMap::new(),
            relocated: 0,
            closed: bodies::Closed::default(),
            limits,
        };
        let named = materials.iter().map(|record| (description.folder.as_path(), &record.material));
        builder.loader.decode_ahead(named);
        for record in materials {
            let (folder, parts) = (&description.folder, &mut builder.parts);
            builder.loader.material(&record.material, Some(&record.origin), folder, Severity::Error, parts);
        }
        builder
    }

    /// Adds one object; what goes wrong is reported and the object left out.
    fn place(&mut self, number: usize, record: &'a ObjectRecord) {
        let geometry = match &record.shape {
            ShapeRecord::Mesh(name) => self.loader.named(name, &mut self.parts),
            ShapeRecord::File { path, crease_angle, simplify } => {
                self.loader.file(path, Treatment::new(*crease_angle, simplify), &mut self.parts)
            }
            other => self.simple_shape(other, !record.transform.is_empty()),
        };
        let Some(Geometry { pieces, materials: own }) = geometry else { return };
        let Some(materials) = self.materials_of(record, &own, &pieces) else { return };
        if self.parts.objects.len() + pieces.len() > self.limits.placed {
            let message = format!("the objects place more than {} shapes", self.limits.placed);
            self.loader.findings.push(Diagnostic::error(message).at(record.origin.clone()));
            return;
        }
        let shapes: Vec<usize> = pieces.iter().map(|piece| piece.shape).collect();
        let Some(transform) = self.transform(&record.transform, &shapes) else { return };
        let name = match &record.name {
            Some(name) => name.value.clone(),
            None => format!("object {}", number + 1),
        };
        for piece in pieces {
            let materials = match piece.material {
                Some(only) => vec![materials[only as usize]],
                None => materials.clone(),
            };
            let object = Object { name: name.clone(), shape: piece.shape, transform, materials, motion: None };
            let open = self.closed.open_edges(&self.parts, &object);
            if open > 0 {
                let edges = if open == 1 { "1 edge has" } else { &format!("{open} edges have") };
                let message = format!("`{name}` bounds a body, but is not closed: {edges} no face on the other side");
                let warning = Diagnostic::warning(message).at(record.origin.clone());
                let help = "close it, or take `interior` and `priority` from its material: light that finds a hole takes what \
                            the body holds along";
                self.loader.findings.push(warning.help(help));
            }
            self.parts.objects.push(object);
        }
    }

    /// The object's own material for all faces, or the file's materials but for those that are replaced, or the mesh's own
    /// colours, or grey.
    fn materials_of(&mut self, record: &ObjectRecord, own: &[usize], pieces: &[Piece]) -> Option<Vec<usize>> {
        let index = match &record.material {
            Some(name) => self.material(name)?,
            None if !own.is_empty() => return self.replaced(&record.materials, own),
            None if self.are_colored(pieces) => {
                let note = Diagnostic::note("no material: the colours of the vertices are its diffuse reflectance");
                self.loader.findings.push(note.at(record.origin.clone()));
                self.colored()
            }
            None => self.grey(),
        };
        Some(vec![index; own.len().max(1)])
    }

    fn are_colored(&self, pieces: &[Piece]) -> bool {
        pieces.iter().any(|piece| match &self.parts.shapes[piece.shape] {
            Shape::Mesh(mesh) => mesh.colors.is_some(),
            Shape::Sphere { .. } | Shape::Rectangle { .. } => false,
        })
    }

    /// A diffuse material of vertex colours.
    fn colored(&mut self) -> usize {
        let materials = &mut self.parts.materials;
        *self.colored_material.get_or_insert_with(|| {
            let texture = Some(Arc::new(Texture::of(Pattern::VertexColor)));
            let reflectance = Color { factor: Spectrum::ONE, texture };
            let mut material = crate::read::default_material();
            material.scattering = Scattering::Diffuse { reflectance, transmittance: Spectrum::BLACK.into() };
            materials.push(material);
            materials.len() - 1
        })
    }

    /// The index of a material of the scene.
    fn material(&mut self, name: &Located<String>) -> Option<usize> {
        let index = self.materials.get(name.value.as_str()).copied();
        if index.is_none() {
            let error = Diagnostic::error(format!("no material is called `{}`", name.value));
            self.loader.findings.push(error.at(name.origin.clone()));
        }
        index
    }

    /// The materials of a file, with others in the place of some.
    fn replaced(&mut self, by: &[[Located<String>; 2]], own: &[usize]) -> Option<Vec<usize>> {
        let mut materials = own.to_vec();
        for [name, other] in by {
            let other = self.material(other)?;
            let names = own.iter().map(|&index| self.parts.materials[index].name.as_str());
            let places: Vec<usize> = (0..).zip(names.clone()).filter(|(_, n)| *n == name.value).map(|p| p.0).collect();
            if places.is_empty() {
                let warning = Diagnostic::warning(format!("the file has no material that is called `{}`", name.value));
                let warning = warning.at(name.origin.clone()).suggest(&name.value, names);
                self.loader.findings.push(warning);
            }
            places.into_iter().for_each(|place| materials[place] = other);
        }
        Some(materials)
    }

    fn grey(&mut self) -> usize {
        let materials = &mut self.parts.materials;
        *self.default_material.get_or_insert_with(|| {
            materials.push(crate::read::default_material());
            materials.len() - 1
        })
    }

    /// Adds a sphere, rectangle, box or disk; `None` for meshes, which the loader adds. Those with the same numbers share one copy if they are `moved` by transforms;
    /// rectangles do not, since a light is sampled best where its corners are known in the world.
    fn simple_shape(&mut self, record: &ShapeRecord, moved: bool) -> Option<Geometry> {
        let bits = |numbers: &[f64]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        let (key, geometry) = match *record {
            ShapeRecord::Sphere { center, radius } => {
                let [x, y, z] = center.to_array();
                (Some(("sphere", bits(&[x, y, z, radius]))), Shape::Sphere { center, radius })
            }
            ShapeRecord::Box { min, max } => {
                let numbers = [min.to_array(), max.to_array()].concat();
                (Some(("box", bits(&numbers))), Shape::Mesh(geometry::cuboid(min, max)))
            }
            ShapeRecord::Disk { radius, segments } => {
                let key = ("disk", bits(&[radius, f64::from(segments)]));
                (Some(key), Shape::Mesh(geometry::disk(radius, segments)))
            }
            ShapeRecord::Rectangle { corner, u, v } => (None, Shape::Rectangle { corner, u, v }),
            ShapeRecord::Mesh(_) | ShapeRecord::File { .. } => return None,
        };
        let new = self.parts.shapes.len();
        let shape = match key.filter(|_| moved) {
            Some(key) => *self.shared.entry(key).or_insert(new),
            None => new,
        };
        if shape == new {
            self.parts.shapes.push(geometry);
        }
        Some(Geometry::of_shape(shape))
    }

    /// The steps composed, for an object of some shapes.
    fn transform(&mut self, steps: &[Located<Step>], shapes: &[usize]) -> Option<DAffine3> {
        let mut transform = DAffine3::IDENTITY;
        for located in steps {
            if let Step::Relocate(_) = located.value {
                let vertices = shapes.iter().map(|&shape| match &self.parts.shapes[shape] {
                    Shape::Mesh(mesh) => mesh.positions.len(),
                    Shape::Sphere { .. } | Shape::Rectangle { .. } => 1,
                });
                self.relocated = self.relocated.saturating_add(vertices.sum());
                if self.relocated > self.limits.relocated_vertices {
                    let message = "too many `relocate` steps of large meshes";
                    self.loader.findings.push(Diagnostic::error(message).at(located.origin.clone()));
                    return None;
                }
            }
            let so_far = transform;
            let lowest_of = |&shape: &usize| view::lowest(&self.parts.shapes[shape], &so_far);
            let lowest = || shapes.iter().map(lowest_of).fold(DVec3::INFINITY, DVec3::min);
            transform = geometry::step(&located.value, lowest) * so_far;
            if !transform.is_finite() || !usable(&transform) {
                let message = "the transform is too large, or flattens the object";
                self.loader.findings.push(Diagnostic::error(message).at(located.origin.clone()));
                return None;
            }
        }
        Some(transform)
    }
}

/// True if single precision can hold a transform and its inverse.
fn usable(transform: &DAffine3) -> bool {
    const LARGEST: f64 = 1e18;
    let small = |m: &DAffine3| m.to_cols_array().iter().all(|x| x.abs() < LARGEST);
    let determinant = transform.matrix3.determinant();
    let axes = transform.matrix3.to_cols_array_2d().map(DVec3::from_array);
    let volume = axes.iter().map(|a| a.length()).product::<f64>();
    small(transform) && determinant.abs() > 1e-12 * volume && small(&transform.inverse())
}
