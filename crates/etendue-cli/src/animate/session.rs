//! Frames one after another.

use super::{
    film::failure_of,
    stamp,
    targets::{FrameFile, Targets},
    view::FilmView,
};
use crate::{
    args::AnimateArgs,
    exit::Failure,
    labels::LabelWriter,
    load::{Job, Loaded},
    progress::TICK,
    render,
};
use etendue::{
    film::Film,
    image::Image,
    render::RenderControl,
    tonemap::{DisplayTransform, Encoding},
};
use etendue_scene::{
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

/// How a signal reaches the frame in work.
#[derive(Default)]
pub struct Stop {
    stopped: AtomicBool,
    control: Mutex<Option<Arc<RenderControl>>>,
}

impl Stop {
    /// No frame after the one in work, which is cancelled.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::SeqCst);
        if let Some(control) = &*self.control.lock().unwrap_or_else(PoisonError::into_inner) {
            control.cancel();
        }
    }

    /// True once it was stopped.
    pub fn is_stopped(&self) -> bool {
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
pub struct Seconds {
    /// Reading the scene, and simulating it.
    load: f64,
    build: f64,
    labels: f64,
    render: f64,
    write: f64,
}

impl Seconds {
    /// When reading and simulating took so long, and nothing else has been done.
    pub fn after_loading(load: f64) -> Self {
        Self { load, ..Self::default() }
    }

    /// For people.
    pub fn table(&self, frames: u64) -> String {
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
pub struct Frame {
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
pub struct Session<'a> {
    args: &'a AnimateArgs,
    loaded: &'a Loaded,
    times: Clock,
    stop: &'a Stop,
    job: Job,
    /// The frame that the job's scene is of; `None` before there is one.
    at: Option<u32>,
    /// Of the whole film.
    seed: u64,
    labels: Option<LabelWriter>,
    /// To standard output.
    pub pipe: Option<Encoder<'static>>,
    /// Hashes of all frames, from a film that was whole before.
    pub whole: Option<Vec<String>>,
    /// Hashes of the frames so far.
    hashes: Vec<String>,
    /// Frames that were not there before.
    pub rendered: u32,
    /// What took how long.
    pub seconds: Seconds,
}

impl<'a> Session<'a> {
    /// With a job that has no scene yet.
    pub fn new(
        args: &'a AnimateArgs,
        loaded: &'a Loaded,
        times: Clock,
        stop: &'a Stop,
        job: Job,
        labels: Option<LabelWriter>,
        seconds: Seconds,
    ) -> Self {
        let seed = job.settings.seed;
        let (pipe, whole, hashes) = (None, None, Vec::new());
        Self { args, loaded, times, stop, job, at: None, seed, labels, pipe, whole, hashes, rendered: 0, seconds }
    }

    /// What a film of these frames is made of.
    pub fn film_stamp(&mut self, frames: RangeInclusive<u32>, settings: Settings) -> Result<String, Failure> {
        stamp::of_film(frames.map(|frame| self.aim(frame)), settings)
    }

    /// Renders a frame and writes its files; `None` if it was stopped before its end. The film begins with frame `first`.
    pub fn frame(
        &mut self,
        targets: &Targets,
        view: &FilmView,
        frame: u32,
        first: u32,
    ) -> Result<Option<Frame>, Failure> {
        if self.stop.is_stopped() {
            return Ok(None);
        }
        let clock = Instant::now();
        let stamp = self.aim(frame)?;
        self.seconds.build += clock.elapsed().as_secs_f64();
        let (time, outputs) = (self.times.time(frame), targets.names(frame));
        let there = self.finished(&targets.files(frame), frame - first, &stamp);
        let labels = self.label(targets, frame, &stamp)?;
        let resumed = there.is_some();
        let film_hash = match there {
            Some(film_hash) => film_hash,
            None => match self.render_frame(targets, view, frame, &stamp)? {
                Some(film_hash) => film_hash,
                None => return Ok(None),
            },
        };
        view.finish_frame();
        if targets.films().next().is_some() {
            self.hashes.push(film_hash.clone());
        }
        Ok(Some(Frame { frame, time, film_hash, outputs, labels, resumed }))
    }

    /// Points the camera and chooses the noise of a frame; returns the frame's stamp.
    fn aim(&mut self, frame: u32) -> Result<String, Failure> {
        let moment = self.times.moment(frame);
        self.loaded.aim(&mut self.job, moment)?;
        self.job.settings.seed = if self.args.fixed_noise { self.seed } else { render::seed_of(self.seed, frame) };
        Ok(stamp::stamp(&self.job, self.loaded.timeline.animation(), moment))
    }

    /// The hash of a frame that need not be rendered: its files are there, or every film that it belongs to. `index` counts from the first.
    fn finished(&self, files: &[FrameFile], index: u32, stamp: &str) -> Option<String> {
        match files {
            _ if !self.args.resume => None,
            [] => self.whole.as_ref()?.get(index as usize).cloned(),
            files => stamp::finished(files, stamp),
        }
    }

    /// Brings the scene to a frame.
    fn bring(&mut self, frame: u32) -> Result<(), Failure> {
        let clock = Instant::now();
        let moment = self.times.moment(frame);
        match self.at {
            Some(at) if at == frame => {}
            Some(_) => self.loaded.advance(&mut self.job, moment)?,
            None => {
                self.loaded.raise(&mut self.job, moment, &self.args.render)?;
                render::warn_of_darkness(&self.job);
            }
        }
        self.at = Some(frame);
        self.seconds.build += clock.elapsed().as_secs_f64();
        Ok(())
    }

    /// Renders a frame and writes it; its hash, or `None` if it was stopped.
    fn render_frame(
        &mut self,
        targets: &Targets,
        view: &FilmView,
        frame: u32,
        stamp: &str,
    ) -> Result<Option<String>, Failure> {
        self.bring(frame)?;
        let clock = Instant::now();
        let film = render::new_film(&self.job.film, &self.args.render)?;
        let control = self.stop.next();
        self.render(view, &film, &control, frame)?;
        let took = clock.elapsed().as_secs_f64();
        self.seconds.render += took;
        if control.is_cancelled() {
            return Ok(None);
        }
        let clock = Instant::now();
        let image = film.develop();
        let film_hash = film_hash(&image);
        let metadata = render::metadata(&self.job, &film, &image, took)
            .with("frame", frame)
            .with("time", self.times.time(frame))
            .with(stamp::FILM_HASH, &film_hash)
            .with(stamp::STAMP, stamp);
        self.write(targets, &image, frame, &metadata)?;
        self.seconds.write += clock.elapsed().as_secs_f64();
        self.rendered += 1;
        Ok(Some(film_hash))
    }

    /// Writes the labels of a frame, if any are asked for and not there. Returns their files.
    fn label(&mut self, targets: &Targets, frame: u32, stamp: &str) -> Result<Vec<String>, Failure> {
        let stem = targets.labels(frame);
        let (Some(writer), Some(stem)) = (&self.labels, stem) else { return Ok(Vec::new()) };
        if self.args.resume && writer.is_done(&stem, stamp) {
            return Ok(Vec::new());
        }
        self.bring(frame)?;
        let clock = Instant::now();
        let Some(writer) = &mut self.labels else { return Ok(Vec::new()) };
        let files = writer.frame((self.loaded, &mut self.job), &self.times, frame, stamp, &stem)?;
        let moment = self.times.moment(frame);
        self.loaded.advance(&mut self.job, moment)?;
        self.loaded.aim(&mut self.job, moment)?;
        self.seconds.labels += clock.elapsed().as_secs_f64();
        Ok(files.iter().map(|file| file.display().to_string()).collect())
    }

    /// Renders on other threads while this one shows progress.
    fn render(&self, view: &FilmView, film: &Film, control: &RenderControl, frame: u32) -> Result<(), Failure> {
        let job = &self.job;
        let watcher = thread::current();
        let rendered = thread::scope(|scope| {
            let worker = scope.spawn(|| {
                let rendered = etendue::render::render(&job.scene, &job.camera, &job.settings, film, control);
                watcher.unpark();
                rendered
            });
            while !worker.is_finished() {
                thread::park_timeout(TICK);
                view.update(frame, control);
            }
            worker.join()
        });
        match rendered {
            Ok(rendered) => rendered.map_err(render::failure_of),
            Err(panic) => panic::resume_unwind(panic),
        }
    }

    fn write(&mut self, targets: &Targets, image: &Image, frame: u32, metadata: &Metadata) -> Result<(), Failure> {
        let display = self.job.display;
        let encode = display.encoder();
        let files = targets.files(frame);
        let size = [image.width, image.height];
        let opaque = (self.pipe.is_some() || files.iter().any(|file| file.is_of_film)).then(|| rgb8(image, display));
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
            pipe.push_rgb8(rgb).map_err(|error| failure_of(&error))?;
        }
        Ok(())
    }

    /// Ends the films, which are made of what the stamp `made` says; false if it was stopped meanwhile.
    pub fn finish(
        &mut self,
        targets: &Targets,
        view: &FilmView,
        frames: RangeInclusive<u32>,
        settings: Settings,
        made: Option<&str>,
    ) -> Result<bool, Failure> {
        let clock = Instant::now();
        if let Some(pipe) = self.pipe.take() {
            pipe.finish().map_err(|error| failure_of(&error))?;
        }
        let Some(made) = made else { return Ok(true) };
        view.say("writing the film");
        let note = stamp::note(made, &self.hashes);
        let whole = targets.finish(frames, settings, &note, &|| self.stop.is_stopped())?.is_some();
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
