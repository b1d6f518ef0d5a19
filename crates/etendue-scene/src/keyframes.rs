//! Files of poses, from a simulator or any other program.

mod json;
mod npy;

use crate::{
    Diagnostic, Diagnostics, FileId, Limits, SourceMap, Span,
    animation::{KeyframeTimes, KeyframesRecord, rotation_of},
    description::SceneDescription,
    diagnostic::nearest,
    track::{Interpolation, PoseTrack},
};
use etendue::{
    math::{DAffine3, DQuat, DVec3},
    motion::Pose,
};
use std::{collections::BTreeMap, path::Path, sync::Arc};

/// Most poses of a file: times by objects.
const MOST_POSES: u64 = 1 << 25;

/// Poses as a file has them.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Of what it was made.
    pub made: Made,
    /// Seconds, strictly ascending; absent: the file has none.
    pub times: Option<Arc<[f64]>>,
    /// What is between.
    pub interpolation: Option<Interpolation>,
    /// True if poses move objects from where the scene puts them, false if they are where objects are.
    pub relative: bool,
    /// What moves.
    pub objects: Vec<Recorded>,
    /// The file.
    pub file: FileId,
}

/// What a file of poses says of how it was made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Made {
    /// Hash of the physics, hexadecimal, by `etendue simulate`; and where it stands.
    pub hash: Option<(String, Span)>,
    /// Seconds of a step of the simulation.
    pub step: Option<f64>,
    /// Poses of each object.
    pub rows: usize,
}

/// Poses of one object.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// Absent where the format has no names.
    pub name: Option<String>,
    /// Where the file says so.
    pub place: Span,
    /// One a time.
    pub poses: Arc<[Pose]>,
    /// See [`PoseTrack::pivot`].
    pub pivot: Option<DVec3>,
}

/// Reads a file of poses: `.json` as `etendue simulate` writes it, or `.npy`, an array `poses[T, N, 4, 4]`.
///
/// # Errors
/// Each with its place.
pub fn read(path: &Path, sources: &mut SourceMap, limits: &Limits) -> Result<Recording, Diagnostics> {
    let only = |error: Diagnostic| {
        let mut found = Diagnostics::new();
        found.push(error);
        found
    };
    let file = sources.read(path, limits.file_bytes).map_err(|error| only(Diagnostic::error(error.to_string())))?;
    let bytes = sources.bytes(file);
    let read = match () {
        () if bytes.starts_with(crate::volume_file::npy::MAGIC) => npy::read(file, &bytes),
        () if bytes.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'{') => json::read(file, &bytes),
        () => {
            let error = Diagnostic::error("this is no file of poses").at(Span::new(file, 0..bytes.len().min(1)));
            Err(error.help("expected JSON of the format `etendue-motion`, or an array poses[T, N, 4, 4] by numpy.save"))
        }
    };
    read.map_err(only)
}

/// The tracks of a description's objects that a recording moves, each with the object's index. `placed` gives of an object its
/// transform and the middle of its bounding box in the world, before any motion; `None` if it could not be loaded. Warnings go to
/// `found`.
///
/// # Errors
/// Names that are not known or given twice, counts that do not fit.
pub fn tracks(
    recording: &Recording,
    record: Option<&KeyframesRecord>,
    description: &SceneDescription,
    placed: &dyn Fn(usize) -> Option<(DAffine3, DVec3)>,
    found: &mut Diagnostics,
) -> Result<Vec<(usize, PoseTrack)>, Diagnostic> {
    let times = times(recording, record, description)?;
    let names = names(recording, record)?;
    let numbers = numbers(description);
    let interpolation = record.and_then(|r| r.interpolation).or(recording.interpolation).unwrap_or_default();
    let relative = record.and_then(|r| r.relative).unwrap_or(recording.relative);
    let mut tracks: BTreeMap<usize, PoseTrack> = BTreeMap::new();
    for (object, (name, place)) in recording.objects.iter().zip(&names) {
        let Some(&number) = numbers.get(name.as_str()) else {
            let warning = Diagnostic::warning(format!("no object is called `{name}`: its poses are not used"));
            let near = nearest(name, numbers.keys().map(String::as_str));
            let warning = warning.at(place.clone());
            found.push(near.map_or(warning.clone(), |near| warning.help(format!("did you mean `{near}`?"))));
            continue;
        };
        let Some((transform, middle)) = placed(number) else { continue };
        let mut track = PoseTrack {
            times: times.clone(),
            poses: object.poses.clone(),
            interpolation,
            pivot: object.pivot.unwrap_or(middle),
        };
        if !relative {
            track = absolute(track, &transform).ok_or_else(|| {
                Diagnostic::error(format!("the transform of `{name}` cannot be undone")).at(place.clone())
            })?;
        }
        if tracks.insert(number, track).is_some() {
            return Err(Diagnostic::error(format!("`{name}` is moved twice")).at(place.clone()));
        }
        if description.objects[number].motion.is_some() {
            let error = Diagnostic::error(format!("`{name}` has a `motion` of its own and poses of a file"));
            return Err(error.at(place.clone()).help("keep one of them"));
        }
    }
    if tracks.is_empty() {
        let error = Diagnostic::error("the file moves no object of the scene").at(Span::new(recording.file, 0..0));
        return Err(error.help("give objects the names that the file has, or name them in `keyframes.objects`"));
    }
    Ok(tracks.into_iter().collect())
}

/// Poses that say where objects are, as poses from where the scene puts them: scales of the transform stay.
fn absolute(track: PoseTrack, transform: &DAffine3) -> Option<PoseTrack> {
    let back = DQuat::from_mat3(&rotation_of(transform.matrix3)?).normalize().conjugate();
    let from = transform.translation;
    let pose = |pose: &Pose| {
        let rotation = (pose.rotation * back).normalize();
        Pose { rotation, translation: pose.translation - rotation * from }
    };
    let poses = track.poses.iter().map(pose).collect();
    Some(PoseTrack { poses, pivot: from, ..track })
}

/// Objects by their names, or as messages call them.
fn numbers(description: &SceneDescription) -> BTreeMap<String, usize> {
    let numbered = (0..description.objects.len()).map(|i| (format!("object {}", i + 1), i));
    let mut numbers: BTreeMap<String, usize> = numbered.collect();
    for (i, object) in description.objects.iter().enumerate() {
        if let Some(name) = &object.name {
            numbers.remove(&format!("object {}", i + 1));
            numbers.insert(name.value.clone(), i);
        }
    }
    numbers
}

/// What each object of the file is called in the scene, and where that is said.
fn names(recording: &Recording, record: Option<&KeyframesRecord>) -> Result<Vec<(String, crate::Origin)>, Diagnostic> {
    let count = recording.objects.len();
    if let Some(given) = record.and_then(|record| record.objects.as_ref()) {
        if given.value.len() != count {
            let message = format!("the file has poses of {count} objects, `objects` names {}", given.value.len());
            return Err(Diagnostic::error(message).at(given.origin.clone()));
        }
        return Ok(given.value.iter().map(|name| (name.value.clone(), name.origin.clone())).collect());
    }
    let own = |object: &Recorded| Some((object.name.clone()?, object.place.into()));
    recording.objects.iter().map(own).collect::<Option<_>>().ok_or_else(|| {
        let error = Diagnostic::error("the file does not say which objects it moves");
        let help = format!("name its {count} objects: keyframes = {{ file = \"...\", objects = [\"...\"] }}");
        error.at(Span::new(recording.file, 0..0)).help(help)
    })
}

/// One time a row.
fn times(
    recording: &Recording,
    record: Option<&KeyframesRecord>,
    description: &SceneDescription,
) -> Result<Arc<[f64]>, Diagnostic> {
    let rows = recording.objects.first().map_or(0, |object| object.poses.len());
    let animation = &description.animation;
    match (record.and_then(|record| record.times.as_ref()), &recording.times) {
        (Some(KeyframeTimes::Each(times)), _) if times.value.len() != rows => {
            let message = format!("the file has {rows} rows of poses, `times` has {}", times.value.len());
            Err(Diagnostic::error(message).at(times.origin.clone()))
        }
        (Some(KeyframeTimes::Each(times)), _) => Ok(times.value.clone().into()),
        (None, Some(times)) => Ok(times.clone()),
        (steps, _) => {
            let (start, fps) = match steps {
                Some(KeyframeTimes::Steps { start, fps }) => (*start, *fps),
                _ => (None, None),
            };
            let start = start.unwrap_or(animation.start);
            let fps = fps.unwrap_or(animation.fps.per_second() / animation.speed);
            let times: Arc<[f64]> = (0..rows).map(|row| start + row as f64 / fps).collect();
            if times.windows(2).all(|pair| pair[0] < pair[1]) {
                return Ok(times);
            }
            let error = Diagnostic::error("the rows of the file are closer in time than numbers can tell");
            Err(error.at(Span::new(recording.file, 0..0)).help("give them a lower `fps`, or an earlier `start`"))
        }
    }
}

/// Refuses counts that would fill the memory.
fn check_count(rows: u64, objects: u64) -> Result<(), String> {
    match rows.checked_mul(objects) {
        Some(count) if count <= MOST_POSES => Ok(()),
        _ => Err(format!("{rows} times {objects} poses; at most {MOST_POSES} are read")),
    }
}
