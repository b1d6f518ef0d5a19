//! `etendue animate`: a scene that moves in, numbered pictures or a film out.

mod film;
mod pattern;
mod session;
mod stamp;
mod targets;
mod turntable;
mod view;

use crate::{
    args::{AnimateArgs, FrameRange},
    bodies,
    exit::{Exit, Failure},
    labels::{LabelWriter, Wanted},
    load::{self, Loaded},
    model, render, report,
    signals::Signals,
};
use etendue_scene::{
    animation::{FrameRate, KeyframesRecord},
    description::{Located, SceneDescription},
    timeline::Clock,
};
use etendue_video::Settings;
use session::{Seconds, Session, Stop};
use std::{sync::Arc, time::Instant};
use targets::Targets;
use view::FilmView;

/// Renders frames as the arguments say.
pub fn run(args: &AnimateArgs) -> Result<Exit, Failure> {
    let mut targets = plan(args)?;
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
    bodies::simulate(&mut loaded, until, &|| stop.is_stopped(), args.render.quiet)?;
    let [first, last] = range(args.frames, loaded.timeline.frames(&times), model::is_model(&args.render.input))?;
    check_cameras(&loaded, &times, [first, last], &stop)?;
    let seconds = Seconds::after_loading(clock.elapsed().as_secs_f64());
    let job = loaded.outline(times.moment(first), &args.render)?;
    let film = render::new_film(&job.film, &args.render)?;
    if !job.film.aovs.is_empty() && !targets.keeps_layers() {
        report::warning("layers are asked for, but only .exr files hold them");
    }
    let area = film.area();
    drop(film);
    let settings = Settings {
        size: [area.width(), area.height()],
        rate: rate_of(loaded.timeline.animation().fps)?,
        frames: u64::from(last - first) + 1,
        quality: args.quality,
    };
    targets.check(settings)?;
    let labels = Wanted::of_frames(&args.render.labels).map(|wanted| LabelWriter::new(&job, wanted)).transpose()?;
    if labels.is_some() {
        targets.prepare_labels(first)?;
    }
    let frames = first..=last;
    let samples = area.pixels() as u64 * u64::from(job.settings.spp);
    let view = FilmView::new(settings.frames, samples, args.render.quiet);
    let mut session = Session::new(args, &loaded, times, &stop, job, labels, seconds);
    let made = targets.films().next().is_some().then(|| session.film_stamp(frames.clone(), settings)).transpose()?;
    if let (Some(made), true) = (&made, args.resume) {
        session.whole = targets.leave_whole(made, settings.frames);
    }
    targets.prepare()?;
    session.pipe = targets.pipe(settings)?;
    let clock = Instant::now();
    for frame in frames.clone() {
        let Some(done) = session.frame(&targets, &view, frame, first)? else { break };
        if args.render.json {
            report::result(&serde_json::to_string(&done).unwrap_or_default())?;
        }
    }
    let whole = !stop.is_stopped() && session.finish(&targets, &view, frames, settings, made.as_deref())?;
    drop(view);
    if !whole {
        let how = if targets.can_resume() { "the same command with --resume goes on" } else { "nothing is kept" };
        report::say(format!("interrupted: {how}"));
        return Ok(Exit::Interrupted);
    }
    if args.render.stats {
        report::say(session.seconds.table(settings.frames));
    } else if !args.render.quiet {
        let names = targets.names(first).join(", ");
        let more = if settings.frames == 1 { "" } else { " ..." };
        let when = match session.rendered {
            0 => "were there already, of the same make".to_owned(),
            _ => format!("in {:.1} s", clock.elapsed().as_secs_f64()),
        };
        report::say(format!("{} frames {when}: {names}{more}", settings.frames));
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
    Some(times.moment(last).end())
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
}
