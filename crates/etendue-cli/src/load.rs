//! From a scene file and the command line to what is rendered.

use crate::{
    args::RenderArgs,
    exit::{Exit, Failure},
    model, report, scene_input,
};
use etendue::{
    camera::CameraSettings,
    film::FilmSettings,
    labels::Subjects,
    render::{MAX_THREADS, RenderSettings},
    scene::{AcceleratorSettings, Scene},
    tonemap::DisplayTransform,
};
use etendue_accel::Isa;
use etendue_scene::{
    Diagnostics, Input, Limits, Severity, SourceMap, build_with,
    description::SceneDescription,
    import::{Import, counted},
    mesh_file::MeshFile,
    read_toml,
    script::is_script,
};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
    thread,
};

/// Everything that a render needs.
pub struct Job {
    /// The immutable scene.
    pub scene: Scene,
    /// How it was built.
    pub accelerator: AcceleratorSettings,
    /// The view.
    pub camera: CameraSettings,
    /// Size, crop and layers.
    pub film: FilmSettings,
    /// How it is rendered.
    pub settings: RenderSettings,
    /// How pictures of 8 bits are made.
    pub display: DisplayTransform,
    /// Names of the objects, in the order of their ids.
    pub object_names: Vec<String>,
    /// The objects that labels are of; none if there are no labels.
    pub subjects: Subjects,
    /// Hash of the files read, hexadecimal.
    pub scene_hash: String,
}

/// A scene whose files have been read, with the command line's overrides in it.
pub struct Loaded {
    input: Input,
    isa: Isa,
}

/// Reads the scene file, or the model, and all that it names; reports what was found.
pub fn load(args: &RenderArgs) -> Result<Loaded, Failure> {
    let isa = choose_isa(args.isa)?;
    let limits = Limits::default();
    let mut sources = SourceMap::new();
    let mut meshes = BTreeMap::new();
    let mut description = if model::is_model(&args.input) {
        let mesh = model::read(&args.input, &mut sources, &limits)?;
        let description = automatic_scene(args, &mesh, &mut sources)?;
        meshes.insert(args.input.clone(), mesh);
        description
    } else {
        let (description, read) = scene_file(args, &mut sources, &limits)?;
        meshes = read;
        description
    };
    override_description(&mut description, args);
    let input = build_with(&description, &mut sources, &limits, meshes).map_err(|found| {
        report::diagnostics(&found, &sources);
        Failure::reported(Exit::of(&found))
    })?;
    tell(&input.findings, &sources);
    if !args.quiet {
        tell_imports(args, &input);
    }
    Ok(Loaded { input, isa })
}

/// What a scene file or script says, and the mesh files that have been read for it.
fn scene_file(
    args: &RenderArgs,
    sources: &mut SourceMap,
    limits: &Limits,
) -> Result<(SceneDescription, BTreeMap<PathBuf, MeshFile>), Failure> {
    let input = scene_input::read(&args.input, sources, limits)?;
    if let Some(option) = args.look.first_given() {
        let message = format!("{option} is for models without a scene file, but {} is one", args.input.display());
        return Err(Failure::new(Exit::Usage, message).hint("edit the scene file instead, or give the model itself"));
    }
    tell(&input.found, sources);
    if is_script(&args.input) && !args.quiet {
        // What a script means here is not what it meant.
        let notes = input.found.iter().filter(|d| d.severity == Severity::Note);
        notes.for_each(|note| report::say(note.one_line(sources)));
    }
    Ok((input.description, input.meshes))
}

/// The scene of a model, read from its text as from a file.
fn automatic_scene(args: &RenderArgs, mesh: &MeshFile, sources: &mut SourceMap) -> Result<SceneDescription, Failure> {
    let text = model::scene_text(args.into(), mesh, None)?;
    let name = format!("automatic scene of {}", args.input.display());
    let bytes = text.into_bytes();
    let file = sources.insert(name, bytes.clone())?;
    let (description, found) = read_toml(file, &bytes, Path::new(""));
    tell(&found, sources);
    description.ok_or(Failure::reported(Exit::of(&found)))
}

/// Errors and warnings are always told; notes by `etendue info`.
fn tell(found: &Diagnostics, sources: &SourceMap) {
    let mut kept = Diagnostics::new();
    kept.extend(found.iter().filter(|d| d.severity != Severity::Note).cloned());
    report::diagnostics(&kept, sources);
}

/// One line for each mesh file, and who tells more.
fn tell_imports(args: &RenderArgs, input: &Input) {
    const MOST: usize = 8;
    let mut seen = BTreeSet::new();
    let imports: Vec<&Import> =
        input.imports.iter().filter(|import| seen.insert((&import.path, import.triangles))).collect();
    let mut told = false;
    for import in imports.iter().take(MOST) {
        let more = import.approximated() + import.ignored() + import.other_findings() > 0;
        told |= more;
        let who = if more { format!(" (etendue info {} tells which)", import.path.display()) } else { String::new() };
        report::say(format!("{import}{who}"));
    }
    if imports.len() > MOST {
        report::say(format!("... and {}", counted(imports.len() - MOST, "more model")));
    }
    let notes = input.findings.count(Severity::Note);
    if notes > 0 && !told {
        report::say(format!("{} (etendue info {} tells them)", counted(notes, "note"), args.input.display()));
    }
    if model::is_model(&args.input) && args.look.up.is_none() {
        report::say("y is up: --up z if the model lies on its side");
    }
}

fn choose_isa(asked: Option<Isa>) -> Result<Isa, Failure> {
    let available = Isa::available();
    match asked {
        None => Ok(Isa::detect()),
        Some(isa) if available.contains(&isa) => Ok(isa),
        Some(isa) => {
            let names: Vec<&str> = available.iter().map(|isa| isa.name()).collect();
            let message = format!("this processor has no {isa}; it has: {}", names.join(", "));
            Err(Failure::new(Exit::Unsupported, message).hint("without --isa the best of these is taken"))
        }
    }
}

/// What the command line says replaces what the file says. Naming the kind that the file has keeps the file's parameters.
fn override_description(description: &mut SceneDescription, args: &RenderArgs) {
    let film = &mut description.film;
    set(&mut film.size, args.size);
    args.display.replace_in(&mut film.display);
    set(&mut film.aovs, args.aov.clone());
    film.transparent |= args.transparent;
    let filter = args.filter.filter(|f| f.name() != film.filter.name());
    set(&mut film.filter, filter);
    set(&mut description.sampler.spp, args.spp);
    set(&mut description.sampler.seed, args.seed);
    set(&mut description.sampler.sampler, args.sampler);
    let record = &mut description.integrator;
    let integrator = args.integrator.filter(|i| i.name() != record.integrator.name());
    set(&mut record.integrator, integrator);
    record.depth = args.depth.or(record.depth);
    set(&mut description.accelerator, args.accel);
}

fn set<T>(value: &mut T, by: Option<T>) {
    if let Some(by) = by {
        *value = by;
    }
}

impl Loaded {
    /// Builds the scene and its accelerator.
    pub fn build(self, args: &RenderArgs) -> Result<Job, Failure> {
        let Self { input, isa } = self;
        let threads = match args.threads {
            Some(threads) => threads as usize,
            None => thread::available_parallelism().map_or(1, |n| n.get().min(MAX_THREADS)),
        };
        let accelerator = AcceleratorSettings { kind: input.accelerator, isa, threads };
        let object_names = input.parts.objects.iter().map(|object| object.name.clone()).collect();
        let subjects = args.labels.labels.as_ref().map(|_| Subjects::of(&input.parts)).unwrap_or_default();
        let scene = Scene::build(input.parts, &accelerator).map_err(|e| {
            let hint = format!("etendue info {} tells what is in it", args.input.display());
            Failure::new(Exit::BadInput, e).hint(hint)
        })?;
        let defaults = RenderSettings::default();
        Ok(Job {
            scene,
            accelerator,
            camera: input.camera,
            film: FilmSettings { crop: args.crop.or(input.film.crop), ..input.film },
            settings: RenderSettings {
                spp: input.spp,
                seed: input.seed,
                threads,
                max_depth: input.max_depth,
                splitting: input.splitting,
                sampler: input.sampler,
                integrator: input.integrator,
                filter: input.filter,
                tile: args.tile.unwrap_or(defaults.tile),
                wave: args.wave.unwrap_or(defaults.wave),
                ..defaults
            },
            display: input.display,
            object_names,
            subjects,
            scene_hash: input.scene_hash.iter().map(|byte| format!("{byte:02x}")).collect(),
        })
    }
}
