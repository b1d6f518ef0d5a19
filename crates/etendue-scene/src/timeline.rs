//! A scene at any time: a description, what was built of it, and what moves or changes.

mod carried;

use crate::{
    Diagnostic, Diagnostics, Input, Limits, SourceMap,
    animation::{AnimationRecord, LengthRecord, Varying},
    build::{self, textures::Textures},
    description::{CameraRecord, Focus, Lens, SceneDescription},
    keyframes::{self, Made, Recording},
    read::Part,
    track::PoseTrack,
};
use etendue::{
    camera::{CameraMotion, CameraSettings},
    material::Material,
    math::{DAffine3, DVec3},
    motion::{Motion, Pose},
    scene::{DeltaLight, Environment, FrameChanges, SceneParts},
};
use std::path::PathBuf;

/// Parts of the way of a camera or light that changes while the shutter is open.
const STEPS: usize = 16;

/// When frames are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Scene time of frame 0, seconds.
    pub start: f64,
    /// Scene seconds from frame to frame.
    pub interval: f64,
    /// Opening and closing of the shutter, fractions of the interval after the frame's time.
    pub shutter: [f64; 2],
    /// Scene seconds that so many frames take: the interval before rounding.
    period: (f64, f64),
}

impl Clock {
    /// As the animation has it.
    pub fn new(animation: &AnimationRecord) -> Self {
        let AnimationRecord { start, speed, fps, shutter, .. } = *animation;
        let period = (speed * f64::from(fps.denominator), f64::from(fps.numerator));
        Self { start, interval: period.0 / period.1, shutter, period }
    }

    /// Scene time of a frame, seconds.
    pub fn time(&self, frame: u32) -> f64 {
        self.start + f64::from(frame) * self.period.0 / self.period.1
    }

    /// The moment of a frame.
    pub fn moment(&self, frame: u32) -> Moment {
        self.moment_at(self.time(frame))
    }

    /// The moment of a frame at a time, seconds.
    pub fn moment_at(&self, time: f64) -> Moment {
        Moment { time, shutter: self.shutter.map(|part| time + part * self.interval) }
    }
}

/// When a picture is taken, seconds of scene time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// When materials, the surroundings and the strength of lights are looked at.
    pub time: f64,
    /// When the shutter opens and closes: what moves or is seen through a camera that does is looked at in between.
    pub shutter: [f64; 2],
}

impl Moment {
    /// With a shutter that is open for no time.
    pub fn at(time: f64) -> Self {
        Self { time, shutter: [time; 2] }
    }

    /// Up to when motion is needed, seconds.
    pub fn end(&self) -> f64 {
        self.shutter[1].max(self.time)
    }
}

/// Motions while the shutter is open, by the index of what moves.
type Motions = Vec<(usize, Motion)>;

/// Of one object: its way, and which of the parts' objects it is.
#[derive(Clone, Debug)]
struct Mover {
    track: PoseTrack,
    placed: std::ops::Range<usize>,
}

/// A scene at any time.
#[derive(Debug)]
pub struct Timeline {
    input: Input,
    animation: AnimationRecord,
    varying: Varying,
    camera: CameraRecord,
    /// Indices of materials that have keys.
    keyed_materials: Vec<usize>,
    folder: PathBuf,
    /// By the description's objects.
    movers: Vec<Option<Mover>>,
    placed: Vec<std::ops::Range<usize>>,
    made: Option<Made>,
}

impl Timeline {
    /// Joins a description with what was built of it; reads the keyframes that it names. Its objects are moved by their own keys and
    /// by keyframes; see [`Self::set_body_track`] for others. Warnings are among the findings of [`Self::input`].
    ///
    /// # Errors
    /// Keyframes that cannot be read or do not fit.
    pub fn new(
        description: &SceneDescription,
        input: Input,
        sources: &mut SourceMap,
        limits: &Limits,
    ) -> Result<Self, Diagnostics> {
        let mut timeline = Self {
            animation: description.animation.clone(),
            varying: description.varying.clone(),
            camera: description.camera.clone(),
            keyed_materials: description.varying.keyed(Part::Materials),
            folder: description.folder.clone(),
            movers: vec![None; description.objects.len()],
            placed: input.placed.clone(),
            made: None,
            input,
        };
        let mut found = Diagnostics::new();
        for (number, object) in description.objects.iter().enumerate() {
            let Some(motion) = &object.motion else { continue };
            let Some((_, middle)) = timeline.placed(number) else { continue };
            match motion.track(motion.pivot.unwrap_or(middle)) {
                Some(track) => timeline.set_track(number, track),
                None => {
                    let error = Diagnostic::error("the object turns too often for a track of keys");
                    found.push(
                        error.at(motion.origin.clone()).help("leave out keys that turn it by many thousand degrees"),
                    );
                }
            }
        }
        if let Some(record) = &description.animation.keyframes {
            let path = description.folder.join(&record.file.value);
            match keyframes::read(&path, sources, limits) {
                Ok(recording) => {
                    timeline.use_keyframes(&recording, description, &mut found);
                    timeline.made = Some(recording.made);
                }
                Err(errors) => errors.iter().for_each(|error| {
                    let placed = if error.origin.is_none() {
                        error.clone().at(record.file.origin.clone())
                    } else {
                        error.clone()
                    };
                    found.push(placed);
                }),
            }
        }
        timeline.input.scene_hash = build::scene_hash(sources);
        timeline.input.files = sources.ids().map(|id| sources.path(id).to_owned()).collect();
        if found.has_errors() {
            found.sort();
            return Err(found);
        }
        timeline.input.findings.append(found);
        Ok(timeline)
    }

    fn use_keyframes(&mut self, recording: &Recording, description: &SceneDescription, found: &mut Diagnostics) {
        let record = description.animation.keyframes.as_ref();
        let tracks = keyframes::tracks(recording, record, description, &|number| self.placed(number), found);
        match tracks {
            Ok(tracks) => tracks.into_iter().for_each(|(number, track)| self.set_track(number, track)),
            Err(error) => found.push(error),
        }
    }

    /// Lets a track move an object of the description; one that is always where the scene file puts the object leaves it at rest.
    fn set_track(&mut self, object: usize, track: PoseTrack) {
        let is_identity = track.is_still() && track.poses.first().is_none_or(|pose| *pose == Pose::IDENTITY);
        if !is_identity {
            self.set_body_track(object, track);
        }
    }

    /// Lets a track move an object of the description, by its index. The object counts as one that moves even where the track never
    /// leaves its place: so what is rendered of a body does not depend on how long it was simulated.
    pub fn set_body_track(&mut self, object: usize, track: PoseTrack) {
        if let (Some(mover), Some(placed)) = (self.movers.get_mut(object), self.placed.get(object)) {
            *mover = Some(Mover { track, placed: placed.clone() });
        }
    }

    /// What moves an object of the description, if anything does.
    pub fn track(&self, object: usize) -> Option<&PoseTrack> {
        self.movers.get(object)?.as_ref().map(|mover| &mover.track)
    }

    /// What the file of poses that was read says of how it was made.
    pub fn made(&self) -> Option<&Made> {
        self.made.as_ref()
    }

    /// Another camera in the place of one without keys.
    pub fn set_camera(&mut self, camera: CameraSettings) {
        self.input.camera = camera;
    }

    /// Lowest and highest corner of the box, in the world, about an object's bounding box in its own axes, before any motion.
    pub fn bounds(&self, object: usize) -> Option<[DVec3; 2]> {
        build::bounds(&self.input.parts, self.placed.get(object)?.clone())
    }

    /// What was built, as it is at the animation's start but for motion.
    pub fn input(&self) -> &Input {
        &self.input
    }

    /// What the scene file says about time.
    pub fn animation(&self) -> &AnimationRecord {
        &self.animation
    }

    /// Frames of the whole animation at a rate: as long as it says it is, else up to the last key of anything; `None` if nothing
    /// has keys.
    pub fn frames(&self, clock: &Clock) -> Option<u32> {
        let up_to = |length: f64| {
            let frames = length / clock.interval;
            frames.is_finite().then_some(frames.clamp(0.0, f64::from(u32::MAX - 1)))
        };
        match self.animation.length {
            Some(LengthRecord::Frames(frames)) => Some(frames),
            Some(LengthRecord::Duration(duration)) => Some((libm::round(up_to(duration)?) as u32).max(1)),
            None => {
                let last = self.last_key()?;
                // A frame on the last key counts, whatever rounding does to it.
                (last > clock.start).then(|| up_to(last - clock.start).map(|frames| (frames + 1e-6) as u32 + 1))?
            }
        }
    }

    /// True if anything moves or changes: it has keys, or poses from a file or a simulation.
    pub fn changes_ever(&self) -> bool {
        self.movers.iter().any(Option::is_some) || Part::ALL.into_iter().any(|part| self.varying.has(part))
    }

    /// The time of the last key of anything, seconds; `None` if nothing has keys.
    pub fn last_key(&self) -> Option<f64> {
        let tracks = self.movers.iter().flatten().filter_map(|mover| mover.track.times.last());
        let keys = Part::ALL.into_iter().filter_map(|part| self.varying.times(part).last());
        tracks.chain(keys).copied().reduce(f64::max)
    }

    /// Where an object is placed: its transform and the middle of the bounding box that it has in its own axes.
    fn placed(&self, object: usize) -> Option<(DAffine3, DVec3)> {
        let placed = self.placed.get(object)?.clone();
        build::middle(&self.input.parts, placed)
    }

    /// Geometry, materials and lights at a moment. What moves at any time has a motion.
    ///
    /// # Errors
    /// Values that keys do not give a sense at that time; so for all that is asked for a time.
    pub fn parts(&self, moment: Moment) -> Result<SceneParts, Diagnostics> {
        let changes = self.changes(moment)?;
        Ok(changed(self.input.parts.clone(), changes))
    }

    /// As [`Self::parts`], when no other time is wanted any more.
    ///
    /// # Errors
    /// The same.
    pub fn into_parts(mut self, moment: Moment) -> Result<SceneParts, Diagnostics> {
        let changes = self.changes(moment)?;
        Ok(changed(std::mem::take(&mut self.input.parts), changes))
    }

    /// What another moment changes of a scene that was built of [`Self::parts`] at any.
    ///
    /// # Errors
    /// As [`Self::parts`].
    pub fn changes(&self, moment: Moment) -> Result<FrameChanges, Diagnostics> {
        let [open, close] = moment.shutter;
        let mut motions = Vec::new();
        for mover in self.movers.iter().flatten() {
            let motion = mover.track.motion(open, close);
            motions.extend(mover.placed.clone().map(|object| (object, motion.clone())));
        }
        let has = |part| self.varying.has(part);
        let (delta_lights, light_motions) = has(Part::Lights).then(|| self.lights(moment)).transpose()?.unzip();
        Ok(FrameChanges {
            motions,
            materials: if has(Part::Materials) { self.materials(moment.time)? } else { Vec::new() },
            delta_lights,
            light_motions: light_motions.unwrap_or_default(),
            environment: has(Part::Environment).then(|| self.environment(moment.time)).transpose()?,
        })
    }

    /// Where the parts' objects are at a time, by their indices, from where the scene file puts them.
    pub fn poses(&self, time: f64) -> Vec<Pose> {
        let mut poses = vec![Pose::IDENTITY; self.input.parts.objects.len()];
        for mover in self.movers.iter().flatten() {
            poses[mover.placed.clone()].fill(mover.track.at(time));
        }
        poses
    }

    /// The lights of a moment, and the motions of those that move while the shutter is open.
    fn lights(&self, moment: Moment) -> Result<(Vec<DeltaLight>, Motions), Diagnostics> {
        let at = |time| Ok::<_, Diagnostics>(self.varying.lights(time)?.iter().map(|light| light.value).collect());
        let mut lights: Vec<DeltaLight> = at(moment.time)?;
        let [open, close] = moment.shutter;
        let mut motions = Motions::new();
        if close > open {
            let shares = self.stages(Part::Lights, moment);
            let stages = shares.iter().map(|share| at(open + (close - open) * share));
            let stages: Vec<Vec<DeltaLight>> = stages.collect::<Result<_, _>>()?;
            for (index, light) in lights.iter_mut().enumerate() {
                let ways = shares.iter().zip(&stages).filter_map(|(share, lights)| Some((*share, *lights.get(index)?)));
                motions.extend(carried::carry(light, ways).map(|motion| (index, motion)));
            }
        }
        Ok((lights, motions))
    }

    /// Shares of the shutter's time at which what has keys and is neither straight nor an object is looked at: even steps and its keys.
    fn stages(&self, part: Part, moment: Moment) -> Vec<f64> {
        let [open, close] = moment.shutter;
        let even = (0..=STEPS).map(|step| step as f64 / STEPS as f64);
        let keys = self.varying.times(part).iter().map(|time| (time - open) / (close - open));
        let mut shares: Vec<f64> = even.chain(keys.filter(|share| *share > 0.0 && *share < 1.0)).collect();
        shares.sort_by(f64::total_cmp);
        shares.dedup();
        shares
    }

    /// An image of the surroundings is not read again.
    fn environment(&self, time: f64) -> Result<Option<Environment>, Diagnostics> {
        let record = self.varying.environment(time)?;
        let mut found = Diagnostics::new();
        let environment = build::environment_at(&record, self.input.parts.environment.as_ref(), &mut found);
        if found.has_errors() { Err(found) } else { Ok(environment) }
    }

    /// The materials that have keys.
    fn materials(&self, time: f64) -> Result<Vec<(usize, Material)>, Diagnostics> {
        let records = self.varying.materials(time)?;
        let mut textures = Textures::of(&self.input.textures);
        let changed = self.keyed_materials.iter().filter_map(|index| Some((*index, records.get(*index)?)));
        Ok(changed.map(|(index, record)| (index, textures.material(&record.material, &self.folder))).collect())
    }

    /// The camera at a time, seconds.
    ///
    /// # Errors
    /// As for [`Self::parts`].
    pub fn camera(&self, time: f64) -> Result<CameraSettings, Diagnostics> {
        if !self.camera_changes() {
            return Ok(self.input.camera);
        }
        let record = if self.varying.has(Part::Camera) { self.varying.camera(time)? } else { self.camera.clone() };
        let focused = self.focused(&record).map(|object| {
            let pose = self.movers[object].as_ref().map_or(Pose::IDENTITY, |mover| mover.track.at(time));
            (self.placed[object].clone(), pose.to_affine())
        });
        build::camera(&record, self.input.film.resolution, &self.input.parts, focused).map_err(|error| {
            let mut found = Diagnostics::new();
            found.push(error);
            found
        })
    }

    /// True if the camera is not the same at all times.
    pub fn camera_changes(&self) -> bool {
        self.varying.has(Part::Camera) || self.focused(&self.camera).is_some()
    }

    /// The moving object that the camera is focused on.
    fn focused(&self, record: &CameraRecord) -> Option<usize> {
        let Lens::Perspective { focus: Focus::Object(name), .. } = &record.lens else { return None };
        let is_it = |placed: &std::ops::Range<usize>| {
            self.input.parts.objects.get(placed.start).is_some_and(|object| object.name == name.value)
        };
        let object = self.placed.iter().position(|placed| !placed.is_empty() && is_it(placed))?;
        self.movers[object].as_ref().map(|_| object)
    }

    /// The way of the camera while the shutter is open; `None` if it rests, or the shutter is open for no time.
    ///
    /// # Errors
    /// As for [`Self::parts`].
    pub fn camera_motion(&self, moment: Moment) -> Result<Option<CameraMotion>, Diagnostics> {
        let [open, close] = moment.shutter;
        if close <= open || !self.camera_changes() {
            return Ok(None);
        }
        let key = |share: f64| Ok((share, self.camera(open + (close - open) * share)?));
        let keys = self.stages(Part::Camera, moment).into_iter().map(key).collect::<Result<Vec<_>, Diagnostics>>()?;
        Ok(Some(CameraMotion { keys: keys.into() }))
    }
}

/// Parts as they are in another frame.
fn changed(mut parts: SceneParts, changes: FrameChanges) -> SceneParts {
    for (index, motion) in changes.motions {
        parts.objects[index].motion = Some(motion);
    }
    for (index, material) in changes.materials {
        parts.materials[index] = material;
    }
    if let Some(lights) = changes.delta_lights {
        (parts.delta_lights, parts.light_motions) = (lights, changes.light_motions);
    }
    parts.environment = changes.environment.unwrap_or(parts.environment);
    parts
}
