//! Labels beside pictures.

use crate::{
    args::{LabelArgs, LabelChoice},
    exit::{Exit, Failure},
    load::Job,
    software,
};
use etendue::labels::{Label, LabelError, LabelSettings, Labeller, Labels, Moment};
use etendue_scene::output::{
    Metadata, Window, atomic,
    labels::{About, LabelFormat, label_record, write_labels},
};
use std::path::{Path, PathBuf};

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

/// Makes and writes the labels of a still.
pub fn write_still(job: &Job, wanted: Wanted, stem: &Path) -> Result<Vec<PathBuf>, Failure> {
    let settings = LabelSettings {
        resolution: job.film.resolution,
        crop: job.film.crop,
        labels: wanted.labels,
        threads: job.settings.threads,
    };
    let mut labeller = Labeller::new(job.subjects.clone(), settings).map_err(failure_of)?;
    let moment = Moment { scene: &job.scene, camera: &job.camera };
    let labels = labeller.label(&moment).map_err(failure_of)?;
    let about = About {
        software: &software(),
        frame: None,
        time: 0.0,
        interval: None,
        resolution: job.film.resolution,
        subjects: labeller.subjects(),
        materials: job.scene.materials(),
        scene_hash: &job.scene_hash,
    };
    Ok(write_labels(stem, wanted.format, &labels, &about, &metadata(&labels, &about))?)
}

/// What the .exr file says about itself.
pub fn metadata(labels: &Labels, about: &About<'_>) -> Metadata {
    let (area, whole) = (labels.area, about.resolution);
    let window = Window { origin: [area.x0, area.y0], whole };
    let metadata = Metadata {
        software: about.software.to_owned(),
        window: (area.width() != whole[0] || area.height() != whole[1]).then_some(window),
        ..Metadata::default()
    };
    metadata.with("sceneHash", about.scene_hash)
}

/// How labels that cannot be made end the program.
pub fn failure_of(error: LabelError) -> Failure {
    let hint = match error {
        LabelError::Size(..) | LabelError::OutOfMemory(_) => "make the picture smaller, or ask for fewer labels",
        LabelError::Crop(..) => "change --crop, or `crop` in [film]",
        LabelError::Camera(_) => "change [camera] in the scene file",
        LabelError::Moment { .. } | LabelError::Accelerator(_) => "leave `visibility` and `flow` out of --labels",
    };
    Failure::new(Exit::BadInput, error).hint(hint)
}
