//! What is told of a scene.

use super::{
    Told,
    records::{Bounds, FindingEntry, KeyEntry, MaterialEntry, Memory, TextureEntry, mesh_bytes, points},
    text::{self, Page},
    volume::MediumEntry,
};
use crate::{
    exit::{Exit, Failure},
    report, scene_input,
};
use etendue::{
    math::DVec3,
    scene::{Environment, SceneParts, Shape},
};
use etendue_scene::{Input, Limits, SourceMap, build_with, import::Import};
use serde::Serialize;
use std::path::Path;

/// A scene.
#[derive(Debug, Serialize)]
pub struct SceneInfo {
    kind: &'static str,
    file: String,
    /// Every file read: the scene's own, meshes, material libraries, images.
    files: Vec<String>,
    /// Width and height, pixels.
    size: [u32; 2],
    spp: u32,
    integrator: &'static str,
    objects: usize,
    /// Kept once, however many objects share them.
    shapes: usize,
    triangles: usize,
    /// Counted once for each object.
    placed_triangles: usize,
    spheres: usize,
    materials: Vec<MaterialEntry>,
    media: Vec<MediumEntry>,
    /// Objects with a material that emits.
    emitting_objects: usize,
    /// Points, spots and the like.
    delta_lights: usize,
    /// `constant`, `image`, or absent.
    environment: Option<&'static str>,
    textures: Vec<TextureEntry>,
    /// A box about all objects, metres; absent without objects. Not tight where objects are turned.
    bounds: Option<Bounds>,
    memory: Memory,
    imports: Vec<ImportEntry>,
    findings: Vec<FindingEntry>,
}

/// A mesh file that the scene reads.
#[derive(Debug, Serialize)]
struct ImportEntry {
    file: String,
    triangles: usize,
    /// Triangles in the file, where `simplify` left fewer.
    simplified_from: Option<usize>,
    vertices: usize,
    spheres: usize,
    materials: usize,
    textures: usize,
    keys: Vec<KeyEntry>,
    /// For people.
    #[serde(skip)]
    line: String,
}

impl ImportEntry {
    fn new(import: &Import, sources: &SourceMap) -> Self {
        Self {
            file: import.path.display().to_string(),
            triangles: import.triangles,
            simplified_from: import.simplified_from,
            vertices: import.vertices,
            spheres: import.spheres,
            materials: import.materials,
            textures: import.textures,
            keys: import.keys.iter().map(|key| KeyEntry::new(key, sources)).collect(),
            line: import.to_string(),
        }
    }
}

/// Reads a scene and all that it names.
pub fn read(path: &Path) -> Result<SceneInfo, Failure> {
    let limits = Limits::default();
    let mut sources = SourceMap::new();
    let scene_input::SceneInput { description, meshes, mut found } = scene_input::read(path, &mut sources, &limits)?;
    let input = build_with(&description, &mut sources, &limits, meshes).map_err(|found| {
        report::diagnostics(&found, &sources);
        Failure::reported(Exit::of(&found))
    })?;
    found.append(input.findings.clone());
    let Input { parts, .. } = &input;
    let textures: Vec<_> = input.textures.iter().map(TextureEntry::new).collect();
    let counts = Counts::of(parts);
    Ok(SceneInfo {
        kind: "scene",
        file: path.display().to_string(),
        files: input.files.iter().map(|path| path.display().to_string()).collect(),
        size: input.film.resolution,
        spp: input.spp,
        integrator: input.integrator.name(),
        objects: parts.objects.len(),
        shapes: parts.shapes.len(),
        triangles: counts.triangles,
        placed_triangles: counts.placed_triangles,
        spheres: counts.spheres,
        materials: parts.materials.iter().map(MaterialEntry::new).collect(),
        media: parts.media.iter().map(MediumEntry::new).collect(),
        emitting_objects: counts.emitting,
        delta_lights: parts.delta_lights.len(),
        environment: parts.environment.as_ref().map(|environment| match environment {
            Environment::Constant(_) => "constant",
            Environment::Image { .. } => "image",
            Environment::Sky { .. } => "sky",
        }),
        bounds: bounds(parts),
        memory: Memory { geometry: counts.bytes, textures: textures.iter().map(|t| t.bytes).sum() },
        textures,
        imports: input.imports.iter().map(|import| ImportEntry::new(import, &sources)).collect(),
        findings: FindingEntry::all(&found, &sources),
    })
}

#[derive(Default)]
struct Counts {
    triangles: usize,
    placed_triangles: usize,
    spheres: usize,
    emitting: usize,
    bytes: usize,
}

impl Counts {
    fn of(parts: &SceneParts) -> Self {
        let mut counts = Self::default();
        for shape in &parts.shapes {
            if let Shape::Mesh(mesh) = shape {
                counts.triangles += mesh.indices.len();
                counts.bytes += mesh_bytes(mesh);
            }
        }
        for object in &parts.objects {
            match &parts.shapes[object.shape] {
                Shape::Mesh(mesh) => {
                    counts.placed_triangles = counts.placed_triangles.saturating_add(mesh.indices.len())
                }
                Shape::Sphere { .. } => counts.spheres += 1,
                Shape::Rectangle { .. } => {}
            }
            let emits = object.materials.iter().any(|&m| parts.materials[m].emission.is_some());
            counts.emitting += usize::from(emits);
        }
        counts
    }
}

/// About the boxes of all objects, each turned with its object.
fn bounds(parts: &SceneParts) -> Option<Bounds> {
    let boxes: Vec<Option<Bounds>> = parts.shapes.iter().map(shape_bounds).collect();
    let corners = parts.objects.iter().filter_map(|object| {
        let corners = boxes[object.shape]?.corners();
        Some(corners.map(|c| object.transform.transform_point3(DVec3::from_array(c)).to_array()))
    });
    Bounds::of(corners.flatten())
}

fn shape_bounds(shape: &Shape) -> Option<Bounds> {
    match shape {
        Shape::Mesh(mesh) => Bounds::of(points(mesh)),
        Shape::Sphere { center, radius } => Bounds::of([center - *radius, center + *radius].map(|p| p.to_array())),
        Shape::Rectangle { corner, u, v } => {
            Bounds::of([*corner, corner + u, corner + v, corner + u + v].map(|p| p.to_array()))
        }
    }
}

impl Told for SceneInfo {
    fn text(&self) -> String {
        let mut page = Page::new(format!("{}: scene", self.file));
        let [width, height] = self.size;
        page.row("picture", format!("{width} x {height}, {} samples per pixel, {}", self.spp, self.integrator));
        page.row("objects", format!("{}, of {} shapes", text::count(self.objects), text::count(self.shapes)));
        let placed = match self.placed_triangles {
            placed if placed == self.triangles => String::new(),
            placed => format!(", {} with instances", text::count(placed)),
        };
        page.row("triangles", text::count(self.triangles) + &placed);
        if self.spheres > 0 {
            page.row("spheres", text::count(self.spheres));
        }
        let environment = self.environment.unwrap_or("no");
        let (emitting, delta) = (text::count(self.emitting_objects), text::count(self.delta_lights));
        page.row("lights", format!("{emitting} objects emit, {delta} without extent, {environment} environment"));
        page.rows("materials", self.materials.iter().map(MaterialEntry::text));
        page.rows("media", self.media.iter().map(MediumEntry::text));
        page.rows("textures", self.textures.iter().map(TextureEntry::text));
        page.rows("bounds", self.bounds.iter().map(|b| format!("{}, metres", b.text())));
        page.row("memory", self.memory.text());
        for import in &self.imports {
            page.row("import", &import.line);
            KeyEntry::rows(&import.keys, &mut page);
        }
        page.rows("files", self.files.iter().cloned());
        let keys: Vec<&KeyEntry> = self.imports.iter().flat_map(|import| &import.keys).collect();
        FindingEntry::rows(&self.findings, &keys, &mut page);
        page.text()
    }
}
