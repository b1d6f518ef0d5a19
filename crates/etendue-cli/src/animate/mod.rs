//! `etendue animate`: a scene that moves in, numbered pictures or a film out.

mod pattern;
mod stamp;
mod targets;
mod view;

use crate::{
    args::{AnimateArgs, FrameRange},
    exit::{Exit, Failure},
    load::{self, Job, Loaded},
    progress::TICK,
    render, report,
    signals::Signals,
};
use etendue::{film::Film, image::Image, render::RenderControl};
use etendue_scene::{
    animation::KeyframesRecord,
    description::{Located, SceneDescription},
    output::{hash::film_hash, write_image},
    timeline::Clock,
};
use serde::Serialize;
use std::{
    panic,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::Instant,
};
use targets::Targets;
use view::FilmView;

/// Renders frames as the arguments say.
pub fn run(args: &AnimateArgs) -> Result<Exit, Failure> {
    let targets = Targets::plan(&args.render.output, args.resume)?;
    let stop = Arc::new(Stop::default());
    let stopped = stop.clone();
    let message = "stopping after the tiles in work; once more to stop at once";
    let signals = Signals::install(move || stopped.stop(), message);

    let clock = Instant::now();
    let loaded = load::load(&args.render, |description| edit(description, args))?;
    let times = Clock::new(loaded.timeline.animation());
    let [first, last] = range(args.frames, loaded.timeline.frames(&times))?;
    let mut seconds = Seconds { load: clock.elapsed().as_secs_f64(), ..Seconds::default() };
    let job = loaded.build_at(times.time(first), &args.render)?;
    let film = render::new_film(&job.film, &args.render)?;
    if !job.film.aovs.is_empty() && !targets.keeps_layers() {
        report::warning("layers are asked for, but only .exr files hold them");
    }
    render::warn_of_darkness(&job);
    check_cameras(&loaded, &times, [first, last])?;

    let total = u64::from(last - first) + 1;
    let samples = film.area().pixels() as u64 * u64::from(job.settings.spp);
    let view = FilmView::new(total, samples, args.render.quiet);
    let mut session = Session {
        args,
        loaded: &loaded,
        times,
        targets: &targets,
        stop: &stop,
        view: &view,
        seed: job.settings.seed,
        job,
    };
    signals.start_work();
    for frame in first..=last {
        if stop.is_stopped() {
            break;
        }
        let Some(done) = session.frame(frame, &mut seconds)? else { break };
        if args.render.json {
            report::result(&serde_json::to_string(&done).unwrap_or_default())?;
        }
    }
    drop(view);
    if stop.is_stopped() {
        report::say("interrupted: the same command with --resume goes on");
        return Ok(Exit::Interrupted);
    }
    if args.render.stats {
        report::say(seconds.table(total));
    }
    Ok(Exit::Done)
}

/// What the command line says of time replaces what the file says.
fn edit(description: &mut SceneDescription, args: &AnimateArgs) -> Result<(), Failure> {
    let animation = &mut description.animation;
    animation.fps = args.fps.unwrap_or(animation.fps);
    animation.speed = args.speed.unwrap_or(animation.speed);
    animation.start = args.start.unwrap_or(animation.start);
    animation.shutter = args.shutter.unwrap_or(animation.shutter);
    if let Some(path) = &args.keyframes {
        let path = std::path::absolute(path)
            .map_err(|e| Failure::new(Exit::BadInput, format!("cannot tell where {} is: {e}", path.display())))?;
        let file = Located { value: path, origin: description.camera.origin.clone() };
        animation.keyframes =
            Some(KeyframesRecord { file, objects: None, times: None, interpolation: None, relative: None });
    }
    Ok(())
}

/// The first and the last frame.
fn range(asked: Option<FrameRange>, whole: Option<u32>) -> Result<[u32; 2], Failure> {
    let unknown = || {
        Failure::new(Exit::Usage, "nothing says how many frames there are: nothing in the scene moves or has keys")
            .hint("give --frames A-B, or `frames` or `duration` in [animation]")
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

/// Finds out before anything is rendered whether the camera has a sense in all frames.
fn check_cameras(loaded: &Loaded, times: &Clock, [first, last]: [u32; 2]) -> Result<(), Failure> {
    if !loaded.timeline.camera_changes() {
        return Ok(());
    }
    for frame in first..=last {
        loaded.timeline.camera_between(times.shutter(frame)).map_err(|found| {
            report::say(format!("in frame {frame}, at {} s:", times.time(frame)));
            load::refused(&found, &loaded.sources)
        })?;
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
    render: f64,
    write: f64,
}

impl Seconds {
    fn table(&self, frames: u64) -> String {
        let rows = [
            ("frames", frames.to_string()),
            ("load", format!("{:.3} s", self.load)),
            ("rebuild", format!("{:.3} s", self.build)),
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
    view: &'a FilmView,
    /// Of the whole film.
    seed: u64,
    job: Job,
}

impl Session<'_> {
    /// Renders a frame and writes its files; `None` if it was stopped before its end.
    fn frame(&mut self, frame: u32, seconds: &mut Seconds) -> Result<Option<Frame>, Failure> {
        let time = self.times.time(frame);
        let files = self.targets.files(frame);
        let outputs = files.iter().map(|(path, _)| path.display().to_string()).collect();
        let clock = Instant::now();
        self.job.camera = self.loaded.camera_at(time)?;
        self.job.settings.seed = if self.args.fixed_noise { self.seed } else { seed_of(self.seed, frame) };
        let [open, close] = self.times.shutter(frame).map(f64::to_bits);
        let stamp = stamp::stamp(&self.job, &format!("{} {open} {close}", time.to_bits()));
        if self.args.resume
            && let Some(film_hash) = stamp::finished(&files, &stamp)?
        {
            self.view.finish_frame();
            return Ok(Some(Frame { frame, time, film_hash, outputs, resumed: true }));
        }
        self.job.scene = self.loaded.scene_at(time, &self.job.accelerator, &self.args.render)?;
        seconds.build += clock.elapsed().as_secs_f64();

        let clock = Instant::now();
        let film = render::new_film(&self.job.film, &self.args.render)?;
        let control = self.stop.next();
        self.render(&film, &control, frame)?;
        let took = clock.elapsed().as_secs_f64();
        seconds.render += took;
        if control.is_cancelled() {
            return Ok(None);
        }
        self.view.finish_frame();

        let clock = Instant::now();
        let image = film.develop();
        let film_hash = film_hash(&image);
        self.write(&film, &image, frame, &stamp, &film_hash, took)?;
        seconds.write += clock.elapsed().as_secs_f64();
        Ok(Some(Frame { frame, time, film_hash, outputs, resumed: false }))
    }

    /// Renders on other threads while this one shows progress.
    fn render(&self, film: &Film, control: &RenderControl, frame: u32) -> Result<(), Failure> {
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
                self.view.update(frame, control);
            }
            worker.join()
        });
        match rendered {
            Ok(rendered) => rendered.map_err(render::failure_of),
            Err(panic) => panic::resume_unwind(panic),
        }
    }

    fn write(
        &self,
        film: &Film,
        image: &Image,
        frame: u32,
        stamp: &str,
        film_hash: &str,
        seconds: f64,
    ) -> Result<(), Failure> {
        let metadata = render::metadata(&self.job, film, image, seconds)
            .with("frame", frame)
            .with("time", self.times.time(frame))
            .with(stamp::FILM_HASH, film_hash)
            .with(stamp::STAMP, stamp);
        let encode = self.job.display.encoder();
        for (path, format) in self.targets.files(frame) {
            write_image(&path, format, image, &metadata, &encode)?;
        }
        Ok(())
    }
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
        assert_eq!(range(None, Some(10)).unwrap(), [0, 9]);
        assert_eq!(range(asked(3, None), Some(10)).unwrap(), [3, 9]);
        assert_eq!(range(asked(3, Some(500)), Some(10)).unwrap(), [3, 500]);
        assert_eq!(range(asked(5, Some(5)), None).unwrap(), [5, 5]);
        assert_eq!(range(asked(10, None), Some(10)).unwrap_err().exit, Exit::Usage);
        assert_eq!(range(None, None).unwrap_err().exit, Exit::Usage);
    }

    #[test]
    fn seeds_differ() {
        let seeds: std::collections::BTreeSet<u64> = (0..1000).map(|frame| seed_of(7, frame)).collect();
        assert_eq!(seeds.len(), 1000);
        assert_ne!(seed_of(0, 1), seed_of(1, 0));
    }
}
