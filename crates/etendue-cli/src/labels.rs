//! Labels beside pictures.

use crate::{
    args::{LabelArgs, LabelChoice},
    exit::{Exit, Failure},
    load::{Job, Loaded},
    software,
};
use etendue::labels::{self, Label, LabelError, LabelSettings, Labeller, Labels, Way};
use etendue_scene::output::{
    Metadata, Window, atomic,
    labels::{About, LabelFormat, label_record, write_labels},
};
use etendue_scene::timeline::{Clock, Moment};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Labels that are asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// Which kinds.
    pub labels: Vec<Label>,
    /// In which files.
    pub format: LabelFormat,
}

impl Wanted {
    /// Those of a picture that nothing moves in.
    pub fn of_still(args: &LabelArgs) -> Result<Option<Self>, Failure> {
        let Some(wanted) = Self::of_frames(args) else { return Ok(None) };
        if args.labels.iter().flatten().any(|choice| *choice == LabelChoice::One(Label::Flow)) {
            let message = "a single picture has no `flow`, which leads to another one";
            return Err(Failure::new(Exit::Usage, message).hint("leave `flow` out of --labels"));
        }
        Ok(Some(Self { labels: wanted.labels.into_iter().filter(|label| *label != Label::Flow).collect(), ..wanted }))
    }

    /// Those of the frames of an animation.
    pub fn of_frames(args: &LabelArgs) -> Option<Self> {
        let choices = args.labels.as_ref()?;
        let chosen = |label: &Label| choices.iter().any(|c| [LabelChoice::All, LabelChoice::One(*label)].contains(c));
        Some(Self { labels: Label::ALL.into_iter().filter(chosen).collect(), format: args.labels_format })
    }
}

/// Where the labels of a picture go: beside it, with its name without the ending.
pub fn stem(picture: &Path) -> PathBuf {
    picture.with_extension("")
}

/// Finds out before the work whether labels can be written.
pub fn check_writable(stem: &Path) -> Result<(), Failure> {
    Ok(atomic::check_writable(&label_record(stem))?)
}

/// Makes and writes labels.
pub struct LabelWriter {
    labeller: Labeller,
    wanted: Wanted,
}

impl LabelWriter {
    /// For the scene of a job.
    pub fn new(job: &Job, wanted: Wanted) -> Result<Self, Failure> {
        let settings = LabelSettings {
            resolution: job.film.resolution,
            crop: job.film.crop,
            labels: wanted.labels.clone(),
            threads: job.settings.threads,
        };
        let labeller = Labeller::new(job.subjects.clone(), settings).map_err(failure_of)?;
        Ok(Self { labeller, wanted })
    }

    /// Those of a still, at a scene time in seconds. Returns the names of the files.
    pub fn still(&mut self, job: &Job, time: f64, stem: &Path) -> Result<Vec<PathBuf>, Failure> {
        let labels = self.look(job)?;
        self.write(job, &labels, About { time, ..self.about(job) }, stem)
    }

    /// Those of a frame. Leaves the job at another moment.
    pub fn frame(
        &mut self,
        (loaded, job): (&Loaded, &mut Job),
        times: &Clock,
        frame: u32,
        stamp: &str,
        stem: &Path,
    ) -> Result<Vec<PathBuf>, Failure> {
        go_to(times.time(frame), loaded, job)?;
        let mut labels = self.look(job)?;
        if self.labeller.wants(Label::Flow) {
            for way in Way::ALL {
                let step = if way == Way::Forward { 1.0 } else { -1.0 };
                go_to(times.start + (f64::from(frame) + step) * times.interval, loaded, job)?;
                let other = labels::Moment { scene: &job.scene, camera: &job.camera };
                self.labeller.follow(&mut labels, way, &other).map_err(failure_of)?;
            }
        }
        let about = About {
            frame: Some(frame.into()),
            time: times.time(frame),
            interval: Some(times.interval),
            stamp: Some(&self.stamp(stamp)),
            ..self.about(job)
        };
        self.write(job, &labels, about, stem)
    }

    /// True if the labels of a frame with this stamp have been written.
    pub fn is_done(&self, stem: &Path, stamp: &str) -> bool {
        let is_stamped = |text: String| text.contains(&format!("{:?}", self.stamp(stamp)));
        fs::read_to_string(label_record(stem)).is_ok_and(is_stamped)
    }

    /// By what finished labels are known again.
    fn stamp(&self, of_frame: &str) -> String {
        let names: Vec<&str> = self.wanted.labels.iter().map(|label| label.name()).collect();
        format!("{of_frame} {} {}", names.join(","), self.wanted.format.name())
    }

    fn look(&mut self, job: &Job) -> Result<Labels, Failure> {
        let moment = labels::Moment { scene: &job.scene, camera: &job.camera };
        self.labeller.label(&moment).map_err(failure_of)
    }

    fn about<'a>(&'a self, job: &'a Job) -> About<'a> {
        About {
            frame: None,
            time: 0.0,
            interval: None,
            stamp: None,
            resolution: job.film.resolution,
            subjects: self.labeller.subjects(),
            materials: job.scene.materials(),
            scene_hash: &job.scene_hash,
        }
    }

    fn write(&self, job: &Job, labels: &Labels, about: About<'_>, stem: &Path) -> Result<Vec<PathBuf>, Failure> {
        let metadata = metadata(labels, job);
        Ok(write_labels(stem, self.wanted.format, labels, &about, &metadata)?)
    }
}

/// Brings a job to a scene time in seconds.
fn go_to(time: f64, loaded: &Loaded, job: &mut Job) -> Result<(), Failure> {
    loaded.advance(job, Moment::at(time))?;
    job.camera = loaded.camera_at(time)?;
    Ok(())
}

/// What the files say about themselves.
fn metadata(labels: &Labels, job: &Job) -> Metadata {
    let (area, whole) = (labels.area, job.film.resolution);
    let window = Window { origin: [area.x0, area.y0], whole };
    let metadata = Metadata {
        software: software(),
        window: (area.width() != whole[0] || area.height() != whole[1]).then_some(window),
        ..Metadata::default()
    };
    metadata.with("sceneHash", &job.scene_hash)
}

/// How labels that cannot be made end the program.
fn failure_of(error: LabelError) -> Failure {
    let hint = match error {
        LabelError::Size(..) | LabelError::OutOfMemory(_) => "make the picture smaller, or ask for fewer labels",
        LabelError::Crop(..) => "change --crop, or `crop` in [film]",
        LabelError::Camera(_) => "change [camera] in the scene file",
        LabelError::Moment { .. } | LabelError::Accelerator(_) => "leave `visibility` and `flow` out of --labels",
    };
    Failure::new(Exit::BadInput, error).hint(hint)
}
