//! `etendue render`: a scene file in, pictures out.

use crate::{
    args::{RenderArgs, StillArgs},
    bodies,
    exit::{Exit, Failure},
    labels::{self, LabelWriter, Wanted},
    load::{self, Loaded},
    manifest,
    outputs::{Outputs, RefreshClock},
    progress::{ProgressView, TICK},
    report,
    signals::Signals,
    software,
    summary::{Seconds, Summary},
};
use etendue::{
    film::{Film, FilmSettings, SampleCounts},
    image::Image,
    integrator::Integrator,
    render::{RenderControl, RenderError, render},
    scene::MAX_NESTED,
};
use etendue_scene::{
    output::{Metadata, Window, hash},
    timeline::{Clock, Moment},
};
use std::{
    panic,
    path::{Path, PathBuf},
    sync::Arc,
    thread,
    time::{Duration, Instant},
};

/// Renders as the arguments say.
pub fn run(still: &StillArgs) -> Result<Exit, Failure> {
    let args = &still.render;
    let outputs = Outputs::plan(&args.output, &args.input)?;
    let wanted = Wanted::of_still(&args.labels)?;
    let stem = labels::stem(outputs.first());
    if wanted.is_some() {
        labels::check_writable(&stem)?;
    }
    let control = Arc::new(RenderControl::default());
    let cancelled = control.clone();
    let message = "stopping after the tiles in work; once more to stop at once";
    let signals = Signals::install(move || cancelled.cancel(), message);
    let mut seconds = Seconds::default();

    let clock = Instant::now();
    let mut loaded = load::load(args, |_| Ok(()))?;
    let moment = moment(still, &loaded);
    if is_timed(still) {
        bodies::simulate(&mut loaded, Some(moment.end()), &|| false, args.quiet)?;
    } else if !args.quiet && (loaded.timeline.changes_ever() || bodies::are_simulated(&loaded.description)) {
        tell_of_time(&loaded);
    }
    seconds.load = lap(clock);
    let clock = Instant::now();
    let (mut job, files) = match wanted {
        Some(wanted) => labelled(&loaded, moment, wanted, &stem, args)?,
        None => (loaded.build(moment, args)?, Vec::new()),
    };
    if let Some(frame) = still.frame {
        job.settings.seed = seed_of(job.settings.seed, frame);
    }
    seconds.build = lap(clock);
    if !job.film.aovs.is_empty() && !outputs.keeps_layers() {
        report::warning("layers are asked for, but only .exr files hold them");
    }
    warn_of_darkness(&job);

    let film = new_film(&job.film, args)?;
    let time = is_timed(still).then_some(moment.time);
    let session = Session { job: &job, film: &film, outputs: &outputs, control: &control, time, quiet: args.quiet };
    signals.start_work();
    let clock = Instant::now();
    session.render()?;
    seconds.render = lap(clock);

    let clock = Instant::now();
    let image = film.develop();
    session.write(&image, seconds.render)?;
    let film_hash = hash::film_hash(&image);
    seconds.write = lap(clock);

    let mut summary = session.summary(&image, seconds, film_hash);
    summary.labels = files.iter().map(|file| file.display().to_string()).collect();
    session.tell(&summary);
    if args.stats {
        let kind = job.accelerator.kind.name();
        report::say(summary.table(&job.scene.stats(), kind, job.accelerator.isa.name(), job.settings.threads));
    }
    if args.json {
        report::result(&summary.json())?;
    }
    Ok(if signals.interrupted() { Exit::Interrupted } else { Exit::Done })
}

/// True if the picture is of a time that the arguments say.
fn is_timed(still: &StillArgs) -> bool {
    still.frame.is_some() || still.time.is_some()
}

/// When the picture is taken: with a frame's shutter if the arguments name a time, else at the start without one.
fn moment(still: &StillArgs, loaded: &Loaded) -> Moment {
    let times = Clock::new(loaded.timeline.animation());
    let framed = still.frame.map(|frame| times.moment(frame));
    framed.or(still.time.map(|time| times.moment_at(time))).unwrap_or(Moment::at(times.start))
}

/// Says that there is more than the picture shows.
fn tell_of_time(loaded: &Loaded) {
    let start = loaded.timeline.animation().start;
    let bodies = match bodies::are_simulated(&loaded.description) {
        true => ", with its bodies where they start",
        false => "",
    };
    report::say(format!(
        "the scene moves, and this is its state at {start} s{bodies}: --time T or --frame K shows another, etendue animate all"
    ));
}

/// A job whose labels, which are taken without motion blur, have been written; and their files.
fn labelled(
    loaded: &Loaded,
    moment: Moment,
    wanted: Wanted,
    stem: &Path,
    args: &RenderArgs,
) -> Result<(load::Job, Vec<PathBuf>), Failure> {
    let sharp = Moment::at(moment.time);
    let mut job = loaded.outline(sharp, args)?;
    loaded.raise(&mut job, sharp, args)?;
    let files = LabelWriter::new(&job, wanted)?.still(&job, moment.time, stem)?;
    if moment != sharp {
        loaded.aim(&mut job, moment)?;
        loaded.advance(&mut job, moment)?;
    }
    Ok((job, files))
}

/// Another seed for each frame (the finaliser of SplitMix64, Steele, Lea and Flood 2014).
pub fn seed_of(seed: u64, frame: u32) -> u64 {
    let mut mixed = seed.wrapping_add((u64::from(frame) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

/// An empty film.
pub fn new_film(settings: &FilmSettings, args: &RenderArgs) -> Result<Film, Failure> {
    Film::new(settings).map_err(|e| {
        // Whoever gave the size or the crop is told so.
        let from_arguments = args.size.is_some() || args.crop.is_some();
        let hint = if from_arguments { "change --size or --crop" } else { "change `size` or `crop` in [film]" };
        Failure::new(if from_arguments { Exit::Usage } else { Exit::BadInput }, e).hint(hint)
    })
}

/// Says why a picture will be darker than its author may think.
pub fn warn_of_darkness(job: &load::Job) {
    let (integrator, scene) = (job.settings.integrator, &job.scene);
    if !matches!(integrator, Integrator::Path | Integrator::LightSplit | Integrator::Brute) {
        return;
    }
    if scene.lights().lights().is_empty() {
        report::warning(
            "nothing in the scene emits light: the picture will be black; add lights, an environment or emission",
        );
    } else if integrator == Integrator::Brute && scene.has_delta_lights() {
        report::warning(
            "`brute` does not see point, spot and directional lights: no ray can hit them; `path` and `light-split` do",
        );
    }
}

fn lap(clock: Instant) -> f64 {
    clock.elapsed().as_secs_f64()
}

/// All that a running render is made of.
struct Session<'a> {
    job: &'a load::Job,
    film: &'a Film,
    outputs: &'a Outputs,
    control: &'a RenderControl,
    /// Scene time, seconds, if it was asked for.
    time: Option<f64>,
    quiet: bool,
}

impl Session<'_> {
    /// Renders on other threads while this one shows progress and refreshes the files.
    fn render(&self) -> Result<(), Failure> {
        let job = self.job;
        let area = self.film.area();
        let view = ProgressView::new(area.pixels() as u64 * u64::from(job.settings.spp), self.quiet);
        let watcher = thread::current();
        let clock = Instant::now();
        let rendered = thread::scope(|scope| {
            let worker = scope.spawn(|| {
                let rendered = render(&job.scene, &job.camera, &job.settings, self.film, self.control);
                watcher.unpark();
                rendered
            });
            let mut refresh = RefreshClock::start();
            while !worker.is_finished() {
                thread::park_timeout(TICK);
                view.update(self.control);
                if refresh.is_due() && !worker.is_finished() {
                    refresh.refreshed(self.refresh(lap(clock)));
                }
            }
            worker.join()
        });
        match rendered {
            Ok(rendered) => rendered.map_err(failure_of),
            Err(panic) => panic::resume_unwind(panic),
        }
    }

    /// Writes the files as they are now; says how long that took. A failure is no reason to stop: there may be room again
    /// at the end.
    fn refresh(&self, seconds: f64) -> Duration {
        let clock = Instant::now();
        if let Err(failure) = self.write(&self.film.develop(), seconds) {
            report::warning(&failure.message);
        }
        clock.elapsed()
    }

    fn write(&self, image: &Image, seconds: f64) -> Result<(), Failure> {
        let encode = self.job.display.encoder();
        let mut metadata = metadata(self.job, self.film, image, seconds);
        if let Some(time) = self.time {
            metadata = metadata.with("time", time);
        }
        Ok(self.outputs.write(image, &metadata, &encode)?)
    }

    fn summary(&self, image: &Image, seconds: Seconds, film_hash: String) -> Summary {
        let counts = self.film.sample_counts();
        Summary {
            outputs: self.outputs.names(),
            labels: Vec::new(),
            width: image.width,
            height: image.height,
            spp: counts.total as f64 / self.film.area().pixels() as f64,
            spp_min: counts.min,
            spp_max: counts.max,
            seconds,
            rays: self.control.rays(),
            paths: self.control.paths(),
            nonfinite: self.film.left_out().count,
            interrupted: self.control.is_cancelled(),
            film_hash,
        }
    }

    /// What people want to know at the end.
    fn tell(&self, summary: &Summary) {
        if let Some([x, y]) = self.film.left_out().first {
            report::warning(&format!(
                "{} samples were not finite or too large and are left out, the first at pixel {x},{y}",
                summary.nonfinite
            ));
        }
        let overflowed = self.control.overflowed();
        if overflowed > 0 {
            report::warning(&format!(
                "{overflowed} paths lay in more than {MAX_NESTED} bodies at once: what the others hold is left out there"
            ));
        }
        let spp = samples_per_pixel(self.film.sample_counts());
        let files = summary.outputs.join(", ");
        if summary.interrupted {
            report::say(format!("interrupted with {spp} of {} samples per pixel: {files}", self.job.settings.spp));
        } else if !self.quiet {
            report::say(format!("{spp} samples per pixel in {:.1} s: {files}", summary.seconds.render));
        }
    }
}

/// What the files of a picture say of it; rendering took `seconds`.
pub fn metadata(job: &load::Job, film: &Film, image: &Image, seconds: f64) -> Metadata {
    let area = film.area();
    let whole = film.resolution();
    let window = Window { origin: [area.x0, area.y0], whole };
    let metadata = Metadata {
        software: software(),
        encoding: job.display.encoding,
        window: (area.width() != whole[0] || area.height() != whole[1]).then_some(window),
        ..Metadata::default()
    }
    .with("seed", job.settings.seed)
    .with("spp", samples_per_pixel(film.sample_counts()))
    .with("sceneHash", &job.scene_hash)
    .with("seconds", format!("{seconds:.3}"))
    .with("display", job.display)
    .with("commandLine", command_line());
    manifest::add(metadata, image, &job.object_names, job.scene.materials())
}

/// `64`, or `32-48` where pixels differ.
fn samples_per_pixel(counts: SampleCounts) -> String {
    if counts.min == counts.max { counts.min.to_string() } else { format!("{}-{}", counts.min, counts.max) }
}

/// Why a render was refused.
pub fn failure_of(error: RenderError) -> Failure {
    match error {
        RenderError::Range { .. } => Failure::new(Exit::Usage, error).hint("etendue render --help tells the ranges"),
        RenderError::Camera(_) | RenderError::Shutter => {
            Failure::new(Exit::BadInput, error).hint("change [camera] in the scene file")
        }
    }
}

/// The command line, quoted so that a POSIX shell reads the same words.
fn command_line() -> String {
    let words = std::env::args_os().map(|word| quote(&word.to_string_lossy()));
    words.collect::<Vec<_>>().join(" ")
}

fn quote(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=@%+".contains(c) || !c.is_ascii();
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_differ() {
        let seeds: std::collections::BTreeSet<u64> = (0..1000).map(|frame| seed_of(7, frame)).collect();
        assert_eq!(seeds.len(), 1000);
        assert_ne!(seed_of(0, 1), seed_of(1, 0));
    }

    #[test]
    fn words_are_quoted_for_a_shell() {
        assert_eq!(quote("--size"), "--size");
        assert_eq!(quote("a b"), "'a b'");
        assert_eq!(quote("it's"), "'it'\\''s'");
        assert_eq!(quote(""), "''");
        assert_eq!(quote("$(x)"), "'$(x)'");
    }

    #[test]
    fn sample_counts_are_told_as_they_are() {
        assert_eq!(samples_per_pixel(SampleCounts { min: 16, max: 16, total: 64 }), "16");
        assert_eq!(samples_per_pixel(SampleCounts { min: 0, max: 16, total: 64 }), "0-16");
    }
}
