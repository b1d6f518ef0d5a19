//! Labels for data sets: what is in each pixel, where it is, where it goes, and how much of each object is seen.
//!
//! Labels are exact, not sampled: of one ray a pixel, through its middle, without lens and blur, at one moment. A ray stops at
//! the first surface that is at least half there (opacity 0.5), of whatever material: glass and mirrors are labelled themselves,
//! not what is seen in them. They depend on neither threads nor accelerators nor instruction sets.

mod first;
mod flow;
mod sight;
mod subjects;
mod view;
mod visibility;

pub use flow::{Flow, Way};
pub use subjects::{Subject, Subjects};
pub use view::{Axes, Intrinsics, View};
pub use visibility::Visibility;

use crate::{
    camera::{CameraError, CameraSettings},
    film::{PixelRect, UnknownName},
    math::{DAffine3, DVec3},
    motion::Pose,
    scene::{Object, Scene},
};
use etendue_accel::BuildError;
use first::Seen;
use std::{fmt, str::FromStr};
use visibility::Outlines;

/// Pixels that labels may have; up to some 150 bytes each.
const MAX_PIXELS: u64 = 1 << 28;

/// One kind of label.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Label {
    /// Number of the object, see [`Subjects`]: 1 and up, 0 for nothing.
    Object,
    /// Number of the material in the scene's order: 1 and up, 0 for nothing.
    Material,
    /// Number of the face in its mesh, 1 and up; 1 on a sphere; 0 for nothing.
    Face,
    /// Distance along the view axis (not along the ray), metres; infinite for nothing.
    Depth,
    /// Unit shading normal in world space, on the side that is seen, without the relief of materials; 0 for nothing.
    Normal,
    /// Position in world space, metres; NaN for nothing.
    Position,
    /// Directional albedo of the material, linear; 0 for nothing.
    Albedo,
    /// Where what is seen goes, and where it comes from, pixels; see [`Flow`].
    Flow,
    /// How much of each object is seen; see [`Visibility`].
    Visibility,
}

impl Label {
    /// All kinds.
    pub const ALL: [Self; 9] = [
        Self::Object,
        Self::Material,
        Self::Face,
        Self::Depth,
        Self::Normal,
        Self::Position,
        Self::Albedo,
        Self::Flow,
        Self::Visibility,
    ];

    /// The name in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Material => "material",
            Self::Face => "face",
            Self::Depth => "depth",
            Self::Normal => "normal",
            Self::Position => "position",
            Self::Albedo => "albedo",
            Self::Flow => "flow",
            Self::Visibility => "visibility",
        }
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Label {
    type Err = UnknownName;
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        Self::ALL.into_iter().find(|label| label.name() == name).ok_or_else(|| UnknownName {
            kind: "label",
            name: name.to_owned(),
            expected: Self::ALL.map(Self::name).join(", "),
        })
    }
}

/// What is labelled.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelSettings {
    /// Width and height of the whole image, pixels.
    pub resolution: [u32; 2],
    /// The part that is labelled: x0, y0 inclusive, x1, y1 exclusive, absolute pixels; absent: all.
    pub crop: Option<[u32; 4]>,
    /// Which kinds; objects always.
    pub labels: Vec<Label>,
    /// Worker threads, at least 1.
    pub threads: usize,
}

/// Labels that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum LabelError {
    /// No pixels, or too many.
    #[error("labels of {0} x {1} pixels: there must be from 1 to {MAX_PIXELS}")]
    Size(u32, u32),
    /// Crop outside of the image.
    #[error("the crop {0:?} is empty or leaves the image of {1} x {2} pixels")]
    Crop([u32; 4], u32, u32),
    /// The allocator refused.
    #[error("not enough memory for labels of {0} pixels")]
    OutOfMemory(usize),
    /// A moment that is not one of the scene.
    #[error("a moment of {found} objects for a scene of {expected}")]
    Moment {
        /// Objects of the scene's parts.
        expected: usize,
        /// Objects of the moment.
        found: usize,
    },
    /// The camera.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The structure about a single object.
    #[error(transparent)]
    Accelerator(#[from] BuildError),
}

/// A scene at one moment.
#[derive(Clone, Copy)]
pub struct Moment<'a> {
    /// With all objects where they are then: what moves counts as it is when the shutter opens.
    pub scene: &'a Scene,
    /// The camera then.
    pub camera: &'a CameraSettings,
}

/// Makes the labels of one frame after the other.
pub struct Labeller {
    subjects: Subjects,
    settings: LabelSettings,
    area: PixelRect,
    outlines: Outlines,
}

/// The labels of one frame: arrays of the area's pixels, row by row from the top left; those that were not asked for are empty.
pub struct Labels {
    /// The part of the image that is labelled.
    pub area: PixelRect,
    /// [`Label::Object`].
    pub object: Vec<u32>,
    /// [`Label::Material`].
    pub material: Vec<u32>,
    /// [`Label::Face`].
    pub face: Vec<u32>,
    /// [`Label::Depth`].
    pub depth: Vec<f32>,
    /// [`Label::Normal`].
    pub normal: Vec<[f32; 3]>,
    /// [`Label::Position`].
    pub position: Vec<[f32; 3]>,
    /// [`Label::Albedo`].
    pub albedo: Vec<[f32; 3]>,
    /// [`Label::Flow`] to the next frame and from the previous one, once [followed](Labeller::follow).
    pub flow: [Option<Flow>; 2],
    /// [`Label::Visibility`], one a subject.
    pub visibility: Option<Vec<Visibility>>,
    /// From the world to the image.
    pub view: View,
    /// Own space to world, then; one a subject.
    pub to_world: Vec<DAffine3>,
    /// Of each object of the parts.
    poses: Vec<Pose>,
    /// Of the scene.
    center: DVec3,
    /// For flow.
    seen: Vec<Seen>,
}

impl Labeller {
    /// Prepares to label a scene of these subjects.
    ///
    /// # Errors
    /// When the size or the crop cannot be.
    pub fn new(subjects: Subjects, settings: LabelSettings) -> Result<Self, LabelError> {
        let [width, height] = settings.resolution;
        if !(1..=MAX_PIXELS).contains(&(u64::from(width) * u64::from(height))) {
            return Err(LabelError::Size(width, height));
        }
        let [x0, y0, x1, y1] = settings.crop.unwrap_or([0, 0, width, height]);
        if !(x0 < x1 && y0 < y1 && x1 <= width && y1 <= height) {
            return Err(LabelError::Crop([x0, y0, x1, y1], width, height));
        }
        Ok(Self { subjects, settings, area: PixelRect { x0, y0, x1, y1 }, outlines: Outlines::default() })
    }

    /// Whose ids these are.
    pub fn subjects(&self) -> &Subjects {
        &self.subjects
    }

    /// True if this kind is asked for.
    pub fn wants(&self, label: Label) -> bool {
        self.settings.labels.contains(&label)
    }

    /// The labels of a moment, but for its flow.
    ///
    /// # Errors
    /// When the moment is none of the scene of the subjects, the camera cannot be, or memory does not do.
    pub fn label(&mut self, moment: &Moment<'_>) -> Result<Labels, LabelError> {
        let poses = self.poses(moment)?;
        let view = View::new(moment.camera, self.settings.resolution)?;
        let place = |subject: &Subject| poses[subject.objects[0]].to_affine() * subject.transform;
        let to_world = self.subjects.list().iter().map(place).collect();
        let mut labels = self.blank(moment.scene.center(), view, poses, to_world)?;
        let rays = first::Rays::new(moment, &self.settings)?;
        first::fill(&mut labels, &rays, &self.subjects, self.settings.threads);
        if self.wants(Label::Visibility) {
            labels.visibility =
                Some(visibility::measure(&labels, &rays, &self.subjects, &mut self.outlines, self.settings.threads)?);
        }
        Ok(labels)
    }

    /// Adds the flow to another moment of the same scene.
    ///
    /// # Errors
    /// As [`Self::label`].
    pub fn follow(&self, labels: &mut Labels, way: Way, other: &Moment<'_>) -> Result<(), LabelError> {
        let poses = self.poses(other)?;
        let view = View::new(other.camera, self.settings.resolution)?;
        let path = flow::Path::new(labels, other.scene, view, &poses);
        let pixels = labels.area.pixels();
        let mut flow = Flow { to: filled(pixels, [f32::NAN; 2])?, occluded: filled(pixels, 1)? };
        path.follow(&mut flow, self.settings.threads);
        labels.flow[way as usize] = Some(flow);
        Ok(())
    }

    /// Where the objects of a moment are, if it is one of the scene.
    fn poses(&self, moment: &Moment<'_>) -> Result<Vec<Pose>, LabelError> {
        let objects = moment.scene.objects();
        let (expected, found) = (self.subjects.objects(), objects.len());
        if found != expected {
            return Err(LabelError::Moment { expected, found });
        }
        let pose = |object: &Object| object.motion.as_ref().map_or(Pose::IDENTITY, |motion| motion.at(0.0));
        Ok(objects.iter().map(pose).collect())
    }

    fn blank(
        &self,
        center: DVec3,
        view: View,
        poses: Vec<Pose>,
        to_world: Vec<DAffine3>,
    ) -> Result<Labels, LabelError> {
        let pixels = self.area.pixels();
        let wanted = |label| if self.wants(label) { pixels } else { 0 };
        Ok(Labels {
            area: self.area,
            object: filled(pixels, 0)?,
            material: filled(wanted(Label::Material), 0)?,
            face: filled(wanted(Label::Face), 0)?,
            depth: filled(wanted(Label::Depth), f32::INFINITY)?,
            normal: filled(wanted(Label::Normal), [0.0; 3])?,
            position: filled(wanted(Label::Position), [f32::NAN; 3])?,
            albedo: filled(wanted(Label::Albedo), [0.0; 3])?,
            flow: [None, None],
            visibility: None,
            view,
            to_world,
            poses,
            center,
            seen: filled(wanted(Label::Flow), Seen::NOTHING)?,
        })
    }
}

fn filled<T: Clone>(count: usize, value: T) -> Result<Vec<T>, LabelError> {
    let mut list = Vec::new();
    list.try_reserve_exact(count).map_err(|_| LabelError::OutOfMemory(count))?;
    list.resize(count, value);
    Ok(list)
}
