//! `etendue animate`: a scene that moves in, numbered pictures or a film out.

mod bodies;
mod film;
mod pattern;
mod stamp;
mod targets;
mod turntable;
mod view;

use crate::{
    args::{AnimateArgs, FrameRange},
    exit::{Exit, Failure},
    labels::{LabelWriter, Wanted},
    load::{self, Job, Loaded},
    model,
    progress::TICK,
    render, report,
    signals::Signals,
};
use etendue::{
    film::Film,
    image::Image,
    render::RenderControl,
    tonemap::{DisplayTransform, Encoding},
};
use etendue_scene::{
    animation::{FrameRate, KeyframesRecord},
    description::{Located, SceneDescription},
    output::{Metadata, atomic, hash::film_hash, png, write_image},
    timeline::Clock,
};
use etendue_video::{Encoder, Settings};
use serde::Serialize;
use std::{
    ops::RangeInclusive,
    panic,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::Instant,
};
use targets::{FrameFile, Targets};
use view::FilmView;

/// Renders frames as the arguments say.
pub fn run(args: &AnimateArgs) -> Result<Exit, Failure> {
    let targets = plan(args)?;
    let stop = Arc::new(Stop::default());
    let stopped = stop.clone();
    let message = "stopping after the tiles in work; once more to stop at once";
    let signals = Signals::install(move || stopped.stop(), message);

    let clock = Instant::now();
    let mut loaded = load::load(&args.render, |description| edit(description, args))?;
    if args.turntable.is_some() {
        let camera = turntable::fit(&loaded.timeline);
        loaded.timeline.set_camera(camera);
    }
    let times = Clock::new(loaded.timeline.animation());
    signals.start_work();
    let until = needed(&loaded, &times, args.frames);
    bodies::simulate(&mut loaded, until, &stop, args.render.quiet)?;
    let [first, last] = range(args.frames, loaded.timeline.frames(&times), model::is_model(&args.render.input))?;
    check_cameras(&loaded, &times, [first, last], &stop)?;
    let mut seconds = Seconds { load: clock.elapsed().as_secs_f64(), ..Seconds::default() };
    let clock = Instant::now();
    let mut job = loaded.build_at(times.moment(first), &args.render)?;
    seconds.build = clock.elapsed().as_secs_f64();
    let film = render::new_film(&job.film, &args.render)?;
    if !job.film.aovs.is_empty() && !targets.keeps_layers() {
        report::warning("layers are asked for, but only .exr files hold them");
    }
    render::warn_of_darkness(&job);
    let area = film.area();
    let settings = Settings {
        size: [area.width(), area.height()],
        rate: rate_of(loaded.timeline.animation().fps)?,
        frames: u64::from(last - first) + 1,
        quality: args.quality,
    };
    targets.prepare(settings)?;
    let labels = Wanted::of_frames(&args.render.labels).map(|wanted| LabelWriter::new(&job, wanted)).transpose()?;
    if labels.is_some() {
        targets.prepare_labels(first)?;
    }

    let samples = area.pixels() as u64 * u64::from(job.settings.spp);
    let view = FilmView::new(settings.frames, samples, args.render.quiet);
    let pipe = targets.pipe(settings)?;
    let seed = job.settings.seed;
    let (loaded, targets, stop) = (&loaded, &targets, &*stop);
    let mut session = Session { args, loaded, times, targets, stop, view, seed, labels, pipe, seconds };
    let clock = Instant::now();
    let mut at = first;
    for frame in first..=last {
        let Some(done) = session.frame(&mut job, &mut at, frame)? else { break };
        if args.render.json {
            report::result(&serde_json::to_string(&done).unwrap_or_default())?;
        }
    }
    let whole = !stop.is_stopped() && session.finish(first..=last, settings)?;
    let Session { view, seconds, .. } = session;
    drop(view);
    if !whole {
        let how = if targets.can_resume() { "the same command with --resume goes on" } else { "nothing is kept" };
        report::say(format!("interrupted: {how}"));
        return Ok(Exit::Interrupted);
    }
    if args.render.stats {
        report::say(seconds.table(settings.frames));
    } else if !args.render.quiet {
        let names = targets.names(first).join(", ");
        let more = if settings.frames == 1 { "" } else { " ..." };
        report::say(format!("{} frames in {:.1} s: {names}{more}", settings.frames, clock.elapsed().as_secs_f64()));
    }
    Ok(Exit::Done)
}

/// The outputs, if they fit together with the other arguments.
fn plan(args: &AnimateArgs) -> Result<Targets, Failure> {
    let targets = Targets::plan(&args.render.output, &args.render.input)?;
    if args.resume {
        targets.check_resume()?;
    }
    if targets.has_pipe() && args.render.json {
        let failure = Failure::new(Exit::Usage, "the film and --json both want standard output");
        return Err(failure.hint("write the film to a file"));
    }
    if args.turntable.is_some() && !model::is_model(&args.render.input) {
        let message =
            format!("--turntable is for models without a scene file, but {} is one", args.render.input.display());
        let hint = "give the object a `motion`, or the camera a `position` with keys, in the scene file";
        return Err(Failure::new(Exit::Usage, message).hint(hint));
    }
    Ok(targets)
}

/// As the encoder has it.
fn rate_of(fps: FrameRate) -> Result<etendue_video::FrameRate, Failure> {
    etendue_video::FrameRate::new(fps.numerator.into(), fps.denominator.into())
        .map_err(|error| film::failure_of(&error))
}

/// What the command line says of time replaces what the file says.
fn edit(description: &mut SceneDescription, args: &AnimateArgs) -> Result<(), Failure> {
    let animation = &mut description.animation;
    animation.fps = args.fps.unwrap_or(animation.fps);
    animation.speed = args.speed.unwrap_or(animation.speed);
    animation.start = args.start.unwrap_or(animation.start);
    animation.shutter = args.shutter.unwrap_or(animation.shutter);
    if let Some(frames) = args.turntable {
        turntable::turn(description, frames);
    }
    let animation = &mut description.animation;
    if let Some(path) = &args.keyframes {
        let path = std::path::absolute(path)
            .map_err(|e| Failure::new(Exit::BadInput, format!("cannot tell where {} is: {e}", path.display())))?;
        let file = Located { value: path, origin: description.camera.origin.clone() };
        animation.keyframes =
            Some(KeyframesRecord { file, objects: None, times: None, interpolation: None, relative: None });
    }
    Ok(())
}

/// Up to when motion is needed, if the arguments or the scene say how many frames there are.
fn needed(loaded: &Loaded, times: &Clock, asked: Option<FrameRange>) -> Option<f64> {
    let length = loaded.timeline.animation().length.and_then(|_| loaded.timeline.frames(times));
    let last = asked.and_then(|range| range.last).or(length.map(|frames| frames.max(1) - 1))?;
    let moment = times.moment(last);
    Some(moment.shutter[1].max(moment.time))
}

/// The first and the last frame.
fn range(asked: Option<FrameRange>, whole: Option<u32>, is_model: bool) -> Result<[u32; 2], Failure> {
    let unknown = || {
        let hint = match is_model {
            true => "--turntable turns the model round once",
            false => "give --frames A-B, or `frames` or `duration` in [animation]",
        };
        let message = "nothing says how many frames there are: nothing in the scene moves or has keys";
        Failure::new(Exit::Usage, message).hint(hint)
    };
    match asked {
        Some(FrameRange { first, last: Some(last) }) => Ok([first, last]),
        asked => {
            let last = whole.ok_or_else(unknown)?.max(1) - 1;
            let first = asked.map_or(0, |range| range.first);
            if first > last {
                let message = format!("the animation ends with frame {last}");
                return Err(Failure::new(Exit::Usage, message).hint("give --frames A-B to render beyond its end"));
            }
            Ok([first, last])
        }
    }
}

/// Finds out before anything is rendered whether the camera has a sense in all frames; after the last key of anything it rests.
fn check_cameras(loaded: &Loaded, times: &Clock, [first, last]: [u32; 2], stop: &Stop) -> Result<(), Failure> {
    let timeline = &loaded.timeline;
    if !timeline.camera_changes() {
        return Ok(());
    }
    let end = timeline.last_key().unwrap_or(times.start);
    for frame in first..=last {
        let moment = times.moment(frame);
        let looked = timeline.camera(moment.shutter[0]).and_then(|_| timeline.camera_motion(moment));
        looked.map_err(|found| {
            report::say(format!("in frame {frame}, at {} s:", moment.time));
            load::refused(&found, &loaded.sources)
        })?;
        if stop.is_stopped() || moment.shutter[0] > end {
            break;
        }
    }
    Ok(())
}

/// How a signal reaches the frame in work.
#[derive(Default)]
struct Stop {
    stopped: AtomicBool,
    control: Mutex<Option<Arc<RenderControl>>>,
}

impl Stop {
    fn stop(&self) {
        self.stopped.store(true, Ordering::SeqCst);
        if let Some(control) = &*self.control.lock().unwrap_or_else(PoisonError::into_inner) {
            control.cancel();
        }
    }

    fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::SeqCst)
    }

    /// A control for the next frame.
    fn next(&self) -> Arc<RenderControl> {
        let control = Arc::new(RenderControl::default());
        *self.control.lock().unwrap_or_else(PoisonError::into_inner) = Some(control.clone());
        // A signal may have come between the frames.
        if self.is_stopped() {
            control.cancel();
        }
        control
    }
}

/// Wall-clock time of all frames' parts, seconds.
#[derive(Clone, Copy, Debug, Default)]
struct Seconds {
    load: f64,
    build: f64,
    labels: f64,
    render: f64,
    write: f64,
}

impl Seconds {
    fn table(&self, frames: u64) -> String {
        let rows = [
            ("frames", frames.to_string()),
            ("load", format!("{:.3} s", self.load)),
            ("rebuild", format!("{:.3} s", self.build)),
            ("labels", format!("{:.3} s", self.labels)),
            ("render", format!("{:.3} s", self.render)),
            ("write", format!("{:.3} s", self.write)),
        ];
        rows.map(|(name, value)| format!("{name:14} {value}")).join("\n")
    }
}

/// What `--json` prints of a frame, one line each.
#[derive(Debug, Serialize)]
struct Frame {
    frame: u32,
    /// Scene time, seconds.
    time: f64,
    film_hash: String,
    outputs: Vec<String>,
    /// Files of labels.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    labels: Vec<String>,
    /// True if it was there before.
    resumed: bool,
}

/// A film in work.
struct Session<'a> {
    args: &'a AnimateArgs,
    loaded: &'a Loaded,
    times: Clock,
    targets: &'a Targets,
    stop: &'a Stop,
    view: FilmView,
    /// Of the whole film.
    seed: u64,
    labels: Option<LabelWriter>,
    /// To standard output.
    pipe: Option<Encoder<'static>>,
    seconds: Seconds,
}

impl Session<'_> {
    /// Renders a frame and writes its files; `None` if it was stopped before its end. `job` is that of frame `at`.
    fn frame(&mut self, job: &mut Job, at: &mut u32, frame: u32) -> Result<Option<Frame>, Failure> {
        if self.stop.is_stopped() {
            return Ok(None);
        }
        let moment = self.times.moment(frame);
        let time = moment.time;
        let outputs = self.targets.names(frame);
        let clock = Instant::now();
        self.loaded.aim(job, moment)?;
        job.settings.seed = if self.args.fixed_noise { self.seed } else { seed_of(self.seed, frame) };
        let stamp = stamp::stamp(job, self.loaded.timeline.animation(), moment);
        if self.args.resume
            && let Some(film_hash) = stamp::finished(&self.targets.files(frame), &stamp)
            && self.has_labels(frame, &stamp)
        {
            self.view.finish_frame();
            return Ok(Some(Frame { frame, time, film_hash, outputs, labels: Vec::new(), resumed: true }));
        }
        self.seconds.build += clock.elapsed().as_secs_f64();
        let labels = self.label(job, at, frame, &stamp)?;
        let clock = Instant::now();
        if *at != frame {
            self.loaded.advance(job, moment)?;
            *at = frame;
        }
        self.seconds.build += clock.elapsed().as_secs_f64();

        let clock = Instant::now();
        let film = render::new_film(&job.film, &self.args.render)?;
        let control = self.stop.next();
        self.render(job, &film, &control, frame)?;
        let took = clock.elapsed().as_secs_f64();
        self.seconds.render += took;
        if control.is_cancelled() {
            return Ok(None);
        }
        self.view.finish_frame();

        let clock = Instant::now();
        let image = film.develop();
        let film_hash = film_hash(&image);
        let metadata = render::metadata(job, &film, &image, took)
            .with("frame", frame)
            .with("time", time)
            .with(stamp::FILM_HASH, &film_hash)
            .with(stamp::STAMP, &stamp);
        self.write(job, &image, frame, &metadata)?;
        self.seconds.write += clock.elapsed().as_secs_f64();
        Ok(Some(Frame { frame, time, film_hash, outputs, labels, resumed: false }))
    }

    /// True unless labels are to be written that are not there.
    fn has_labels(&self, frame: u32, stamp: &str) -> bool {
        let (Some(writer), Some(stem)) = (&self.labels, self.targets.labels(frame)) else { return true };
        writer.is_done(&stem, stamp)
    }

    /// Writes the labels of a frame, if any are asked for, and leaves the job at another moment then. Returns their files.
    fn label(&mut self, job: &mut Job, at: &mut u32, frame: u32, stamp: &str) -> Result<Vec<String>, Failure> {
        let (Some(writer), Some(stem)) = (&mut self.labels, self.targets.labels(frame)) else { return Ok(Vec::new()) };
        let clock = Instant::now();
        let files = writer.frame((self.loaded, job), &self.times, frame, stamp, &stem)?;
        let moment = self.times.moment(frame);
        self.loaded.advance(job, moment)?;
        self.loaded.aim(job, moment)?;
        *at = frame;
        self.seconds.labels += clock.elapsed().as_secs_f64();
        Ok(files.iter().map(|file| file.display().to_string()).collect())
    }

    /// Renders on other threads while this one shows progress.
    fn render(&self, job: &Job, film: &Film, control: &RenderControl, frame: u32) -> Result<(), Failure> {
        let watcher = thread::current();
        let rendered = thread::scope(|scope| {
            let worker = scope.spawn(|| {
                let rendered = etendue::render::render(&job.scene, &job.camera, &job.settings, film, control);
                watcher.unpark();
                rendered
            });
            while !worker.is_finished() {
                thread::park_timeout(TICK);
                self.view.update(frame, control);
            }
            worker.join()
        });
        match rendered {
            Ok(rendered) => rendered.map_err(render::failure_of),
            Err(panic) => panic::resume_unwind(panic),
        }
    }

    fn write(&mut self, job: &Job, image: &Image, frame: u32, metadata: &Metadata) -> Result<(), Failure> {
        let encode = job.display.encoder();
        let files = self.targets.files(frame);
        let size = [image.width, image.height];
        let opaque =
            (self.pipe.is_some() || files.iter().any(|file| file.is_of_film)).then(|| rgb8(image, job.display));
        for FrameFile { path, format, is_of_film } in &files {
            match &opaque {
                Some(rgb) if *is_of_film => {
                    let metadata = Metadata { encoding: Encoding::Srgb, ..metadata.clone() };
                    atomic::write(path, |file| png::write_rgb8(file, size, rgb, &metadata))?;
                }
                _ => write_image(path, *format, image, metadata, &encode)?,
            }
        }
        if let (Some(pipe), Some(rgb)) = (&mut self.pipe, &opaque) {
            pipe.push_rgb8(rgb).map_err(|error| film::failure_of(&error))?;
        }
        Ok(())
    }

    /// Ends the films; false if it was stopped meanwhile.
    fn finish(&mut self, frames: RangeInclusive<u32>, settings: Settings) -> Result<bool, Failure> {
        let clock = Instant::now();
        if let Some(pipe) = self.pipe.take() {
            pipe.finish().map_err(|error| film::failure_of(&error))?;
        }
        if self.targets.films().next().is_some() {
            self.view.say("writing the film");
        }
        let whole = self.targets.finish(frames, settings, &|| self.stop.is_stopped())?.is_some();
        self.seconds.write += clock.elapsed().as_secs_f64();
        Ok(whole)
    }
}

/// The colour of a picture, over black, as screens show it.
fn rgb8(image: &Image, display: DisplayTransform) -> Vec<u8> {
    let encode = DisplayTransform { encoding: Encoding::Srgb, ..display }.encoder();
    let channel = |name| image.f32_channel(name).unwrap_or_default();
    let colours = channel("R").iter().zip(channel("G")).zip(channel("B"));
    colours.flat_map(|((r, g), b)| encode([*r, *g, *b])).collect()
}

/// Another seed for each frame (the finaliser of SplitMix64, Steele, Lea and Flood 2014).
fn seed_of(seed: u64, frame: u32) -> u64 {
    let mut mixed = seed.wrapping_add((u64::from(frame) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_that_there_are() {
        let asked = |first, last| Some(FrameRange { first, last });
        assert_eq!(range(None, Some(10), false).unwrap(), [0, 9]);
        assert_eq!(range(asked(3, None), Some(10), false).unwrap(), [3, 9]);
        assert_eq!(range(asked(3, Some(500)), Some(10), false).unwrap(), [3, 500]);
        assert_eq!(range(asked(5, Some(5)), None, false).unwrap(), [5, 5]);
        assert_eq!(range(asked(10, None), Some(10), false).unwrap_err().exit, Exit::Usage);
        assert_eq!(range(None, None, false).unwrap_err().exit, Exit::Usage);
    }

    #[test]
    fn seeds_differ() {
        let seeds: std::collections::BTreeSet<u64> = (0..1000).map(|frame| seed_of(7, frame)).collect();
        assert_eq!(seeds.len(), 1000);
        assert_ne!(seed_of(0, 1), seed_of(1, 0));
    }
}
