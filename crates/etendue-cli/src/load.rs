//! From a scene file and the command line to what is rendered.

use crate::{
    args::RenderArgs,
    exit::{Exit, Failure},
    model, report, scene_input, stale,
};
use etendue::{
    camera::CameraSettings,
    film::FilmSettings,
    labels::Subjects,
    render::{MAX_THREADS, RenderSettings},
    scene::{AcceleratorSettings, Scene, SceneParts},
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
    timeline::{Moment, Timeline},
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
    /// The scene at any time.
    pub timeline: Timeline,
    /// What it was made of.
    pub description: SceneDescription,
    /// Its files, for messages.
    pub sources: SourceMap,
    isa: Isa,
}

/// Reads the scene file, or the model, and all that it names; reports what was found. `edit` may change the description before
/// anything is made of it.
pub fn load(
    args: &RenderArgs,
    edit: impl FnOnce(&mut SceneDescription) -> Result<(), Failure>,
) -> Result<Loaded, Failure> {
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
    edit(&mut description)?;
    let timeline = build_with(&description, &mut sources, &limits, meshes)
        .and_then(|input| Timeline::new(&description, input, &mut sources, &limits))
        .map_err(|found| refused(&found, &sources))?;
    tell(&timeline.input().findings, &sources);
    tell(&stale::check(&args.input, &description, &timeline), &sources);
    if !args.quiet {
        tell_imports(args, timeline.input());
    }
    Ok(Loaded { timeline, description, sources, isa })
}

/// Errors, told.
pub fn refused(found: &Diagnostics, sources: &SourceMap) -> Failure {
    report::diagnostics(found, sources);
    Failure::reported(Exit::of(found))
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
    /// All of a job but the scene, which is empty, at a moment.
    pub fn outline(&self, moment: Moment, args: &RenderArgs) -> Result<Job, Failure> {
        let input = self.timeline.input();
        let settings = self.settings(args);
        let accelerator = AcceleratorSettings { kind: input.accelerator, isa: self.isa, threads: settings.threads };
        let mut job = Job {
            scene: build_scene(SceneParts::default(), &accelerator, args)?,
            accelerator,
            camera: input.camera,
            film: FilmSettings { crop: args.crop.or(input.film.crop), ..input.film.clone() },
            settings,
            display: input.display,
            object_names: names(input),
            subjects: subjects(input, args),
            scene_hash: hash_of(input),
        };
        self.aim(&mut job, moment)?;
        Ok(job)
    }

    /// The scene at a moment, with its accelerator, and all else that a render needs. No other moment is wanted any more.
    pub fn build(self, moment: Moment, args: &RenderArgs) -> Result<Job, Failure> {
        let mut job = self.outline(moment, args)?;
        let parts = self.timeline.into_parts(moment).map_err(|found| refused(&found, &self.sources))?;
        job.scene = build_scene(parts, &job.accelerator, args)?;
        Ok(job)
    }

    /// Gives a job that has none the scene at a moment.
    pub fn raise(&self, job: &mut Job, moment: Moment, args: &RenderArgs) -> Result<(), Failure> {
        let parts = self.timeline.parts(moment).map_err(|found| refused(&found, &self.sources))?;
        job.scene = build_scene(parts, &job.accelerator, args)?;
        Ok(())
    }

    /// Points the camera as it is at a moment.
    pub fn aim(&self, job: &mut Job, moment: Moment) -> Result<(), Failure> {
        let motion = self.timeline.camera_motion(moment).map_err(|found| refused(&found, &self.sources))?;
        job.camera = self.camera_at(moment.shutter[0])?;
        job.settings.camera_motion = motion;
        job.settings.shutter = self.timeline.animation().curve;
        Ok(())
    }

    /// Brings the scene of a job to another moment: only what has changed is made anew.
    pub fn advance(&self, job: &mut Job, moment: Moment) -> Result<(), Failure> {
        let changes = self.timeline.changes(moment).map_err(|found| refused(&found, &self.sources))?;
        let nothing = Scene::build(SceneParts::default(), &job.accelerator);
        let scene = std::mem::replace(&mut job.scene, nothing.map_err(|error| Failure::new(Exit::BadInput, error))?);
        job.scene =
            scene.with_frame(changes, job.settings.threads).map_err(|error| Failure::new(Exit::BadInput, error))?;
        Ok(())
    }

    /// The camera at a time.
    pub fn camera_at(&self, time: f64) -> Result<CameraSettings, Failure> {
        self.timeline.camera(time).map_err(|found| refused(&found, &self.sources))
    }

    fn settings(&self, args: &RenderArgs) -> RenderSettings {
        let input = self.timeline.input();
        let threads = match args.threads {
            Some(threads) => threads as usize,
            None => thread::available_parallelism().map_or(1, |n| n.get().min(MAX_THREADS)),
        };
        let defaults = RenderSettings::default();
        RenderSettings {
            spp: input.spp,
            seed: input.seed,
            threads,
            max_depth: input.max_depth,
            splitting: input.splitting,
            resampling: None,
            sampler: input.sampler,
            integrator: input.integrator,
            filter: input.filter,
            tile: args.tile.unwrap_or(defaults.tile),
            wave: args.wave.unwrap_or(defaults.wave),
            ..defaults
        }
    }
}

/// Builds a scene and its accelerator.
fn build_scene(parts: SceneParts, accelerator: &AcceleratorSettings, args: &RenderArgs) -> Result<Scene, Failure> {
    Scene::build(parts, accelerator).map_err(|e| {
        let hint = format!("etendue info {} tells what is in it", args.input.display());
        Failure::new(Exit::BadInput, e).hint(hint)
    })
}

fn names(input: &Input) -> Vec<String> {
    input.parts.objects.iter().map(|object| object.name.clone()).collect()
}

/// What labels are of, if there are any.
fn subjects(input: &Input, args: &RenderArgs) -> Subjects {
    args.labels.labels.as_ref().map(|_| Subjects::of(&input.parts)).unwrap_or_default()
}

fn hash_of(input: &Input) -> String {
    input.scene_hash.iter().map(|byte| format!("{byte:02x}")).collect()
}
