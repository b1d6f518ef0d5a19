//! A scene as it was written down: plain named records, each with its origin. Nothing is built and no file but the scene
//! file has been read.

use crate::{
    Origin,
    animation::{AnimationRecord, MotionRecord, Varying},
    physics::{BodyRecord, JointRecord, PhysicsRecord},
    simplify::SimplifyRecord,
    sun_position::Moment,
    volume_file::{Axes, RawLayout},
};
use etendue::{
    film::Aov,
    integrator::Integrator,
    material::Material,
    math::DVec3,
    medium::Medium,
    sampling::{Filter, Sampler},
    scene::{DeltaLight, Mesh},
    spectrum::Spectrum,
    texture::{Texture, Transfer},
    tonemap::DisplayTransform,
};
use etendue_accel::AcceleratorKind;
use std::{path::PathBuf, sync::Arc};

/// A value and where it was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Located<T> {
    /// The value.
    pub value: T,
    /// Its place.
    pub origin: Origin,
}

/// Everything that a scene file says, defaults filled in.
#[derive(Clone, Debug)]
pub struct SceneDescription {
    /// Where relative file names start.
    pub folder: PathBuf,
    /// The view.
    pub camera: CameraRecord,
    /// The picture.
    pub film: FilmRecord,
    /// Random numbers.
    pub sampler: SamplerRecord,
    /// Light transport.
    pub integrator: IntegratorRecord,
    /// Ray traversal.
    pub accelerator: AcceleratorKind,
    /// Light from all around; absent: black.
    pub environment: Option<EnvironmentRecord>,
    /// What bodies and the world may be filled with, by name.
    pub media: Vec<MediumRecord>,
    /// Name of the medium that fills all space outside of bodies; absent: nothing does.
    pub world_medium: Option<Located<String>>,
    /// Materials, by name.
    pub materials: Vec<MaterialRecord>,
    /// Shared geometry, by name.
    pub meshes: Vec<MeshRecord>,
    /// Things in the scene, in the order of the file.
    pub objects: Vec<ObjectRecord>,
    /// Lights that no ray can meet.
    pub lights: Vec<Located<DeltaLight>>,
    /// Time.
    pub animation: AnimationRecord,
    /// What has other values at other times; here it has those of the animation's start.
    pub varying: Varying,
    /// What holds for all bodies.
    pub physics: PhysicsRecord,
    /// What joins bodies, in the order of the file.
    pub joints: Vec<JointRecord>,
}

/// Light from all around.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentRecord {
    /// The same radiance from every direction, W sr^-1 m^-2.
    Constant(Spectrum),
    /// A sky that depends on the height alone, linear in the sine of the elevation; radiance, W sr^-1 m^-2.
    Gradient {
        /// Straight up.
        top: Spectrum,
        /// All around.
        horizon: Spectrum,
        /// Straight down.
        bottom: Spectrum,
        /// Where up is.
        up: UpAxis,
    },
    /// An equirectangular image of radiance.
    Image {
        /// The file; relative to [`SceneDescription::folder`].
        file: Located<PathBuf>,
        /// Multiplies the image.
        strength: Spectrum,
        /// Degrees about the up axis, counter-clockwise seen from above.
        rotation: f64,
        /// Where up is.
        up: UpAxis,
    },
    /// A clear sky, computed.
    Sky(SkyRecord),
}

/// A clear sky with its sun.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyRecord {
    /// Where the sun is.
    pub sun: SunRecord,
    /// Where up is.
    pub up: UpAxis,
    /// Where north is; not along the up axis. Absent: -z where y is up, y where z is.
    pub north: Option<DVec3>,
    /// Molecules and aerosol over molecules alone.
    pub turbidity: f64,
    /// Reflectance of the ground.
    pub ground: Spectrum,
    /// Multiplies all light.
    pub strength: Spectrum,
    /// Half of the angle that the sun is seen under, degrees.
    pub sun_size: f64,
    /// True if the sun can be seen and throws shadows.
    pub sun_disk: bool,
    /// Where the table is.
    pub origin: Origin,
}

/// Where the sun is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SunRecord {
    /// Towards it, of any length but 0.
    Direction(DVec3),
    /// Degrees.
    Angles {
        /// Above the horizon.
        elevation: f64,
        /// Clockwise from north, as on a compass.
        azimuth: f64,
    },
    /// Where it is seen from a place on Earth at some time.
    Moment {
        /// When.
        moment: Moment,
        /// Degrees north.
        latitude: f64,
        /// Degrees east.
        longitude: f64,
    },
}

/// The axis that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// +y, as most models for pictures have it.
    #[default]
    Y,
    /// +z, as much of what comes from CAD has it.
    Z,
}

impl UpAxis {
    /// Both axes.
    pub const ALL: [Self; 2] = [Self::Y, Self::Z];

    /// The axis.
    pub fn direction(self) -> DVec3 {
        match self {
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }

    /// As in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Y => "y",
            Self::Z => "z",
        }
    }
}

/// The view.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraRecord {
    /// Centre of projection, metres.
    pub position: DVec3,
    /// What it looks at.
    pub view: View,
    /// Up in the picture.
    pub up: DVec3,
    /// Degrees that the camera is turned about its view, clockwise as the photographer sees it.
    pub roll: f64,
    /// Distance along the view of the plane on which rays begin, metres.
    pub near_clip: f64,
    /// How points of the image become rays.
    pub lens: Lens,
    /// Where the camera is described.
    pub origin: Origin,
}

/// What a camera looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// A point, metres.
    LookAt(DVec3),
    /// A direction of any length but 0.
    Direction(DVec3),
}

/// Which side of the image a field of view spans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FovAxis {
    /// The width.
    X,
    /// The height.
    Y,
    /// The shorter side.
    Smaller,
    /// The longer side.
    Larger,
}

/// How much of the scene a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Angle {
    /// A field of view.
    Field {
        /// Degrees, in (0, 180).
        fov: f64,
        /// The side that `fov` spans.
        axis: FovAxis,
    },
    /// A lens before a sensor, focused on infinity: `fov` is 2 atan(side / (2 length)).
    Focal {
        /// Focal length, millimetres.
        length: f64,
        /// Width of the sensor, millimetres.
        width: f64,
        /// Its height, millimetres. Of a picture of another shape the largest that fits on the sensor is taken; absent: the
        /// width is spanned.
        height: Option<f64>,
    },
}

/// The opening of a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ApertureRecord {
    /// A disk.
    Round,
    /// A square.
    Square {
        /// Degrees, counter-clockwise.
        rotation: f64,
    },
    /// An iris.
    Polygon {
        /// At least 3.
        blades: u32,
        /// Degrees, counter-clockwise.
        rotation: f64,
    },
}

/// What a lens is focused on.
#[derive(Clone, Debug, PartialEq)]
pub enum Focus {
    /// The point looked at, if there is one.
    Target,
    /// Metres along the view axis.
    Distance(f64),
    /// A point, metres.
    Point(Located<DVec3>),
    /// The middle of the bounding box of the object with this name.
    Object(Located<String>),
}

/// How points of the image become rays.
#[derive(Clone, Debug, PartialEq)]
pub enum Lens {
    /// A pinhole or thin lens.
    Perspective {
        /// How much it sees.
        angle: Angle,
        /// Metres; 0 is a pinhole.
        radius: f64,
        /// The lens's shape.
        aperture: ApertureRecord,
        /// Where the plane in focus is.
        focus: Focus,
    },
    /// Parallel rays.
    Orthographic {
        /// Height of the image, metres.
        height: f64,
    },
}

/// The picture.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmRecord {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Part that is rendered: x0, y0 inclusive, x1, y1 exclusive, pixels from the top left of the whole.
    pub crop: Option<Located<[u32; 4]>>,
    /// Reconstruction.
    pub filter: Filter,
    /// How the picture becomes 8 bits.
    pub display: DisplayTransform,
    /// Layers beside the colour.
    pub aovs: Vec<Aov>,
    /// Nothing is to be seen where camera rays meet no surface.
    pub transparent: bool,
}

/// Random numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplerRecord {
    /// Where they come from.
    pub sampler: Sampler,
    /// Samples per pixel.
    pub spp: u32,
    /// The seed.
    pub seed: u64,
}

/// Light transport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegratorRecord {
    /// The estimator.
    pub integrator: Integrator,
    /// Most edges of a path, the camera segment included; absent: no limit.
    pub depth: Option<u32>,
    /// Parts of a sample, absent for as many as are worth it: see [`RenderSettings::splitting`](etendue::render::RenderSettings::splitting).
    pub splitting: Option<u32>,
}

/// A material.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialRecord {
    /// The material, with its name.
    pub material: Material<TextureRecord>,
    /// Where the name of its interior is, if it has one.
    pub interior: Option<Origin>,
    /// Where its name is.
    pub origin: Origin,
}

/// A medium.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumRecord {
    /// The medium, with its name, without a grid.
    pub medium: Medium,
    /// Its density, where that varies.
    pub density: Option<DensityRecord>,
    /// Where its name is.
    pub origin: Origin,
}

/// Density that varies over space.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityRecord {
    /// The volume; relative to [`SceneDescription::folder`].
    pub file: Located<PathBuf>,
    /// Lowest corner of its box before the transform, metres.
    pub min: DVec3,
    /// Highest corner, metres.
    pub max: DVec3,
    /// Applied to the box, in order.
    pub transform: Vec<Located<Step>>,
    /// Multiplies the values.
    pub scale: f32,
    /// What a raw file holds; absent: the file says so.
    pub layout: Option<RawLayout>,
    /// What the indices of the file's array count; absent: as is usual for its format.
    pub axes: Option<Axes>,
}

/// A texture whose images are names of files; shared by all that name it.
pub type TextureRecord = Arc<Texture<ImageRecord>>;

/// An image by its file.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageRecord {
    /// The file; relative to [`SceneDescription::folder`], or in a material library to the library's folder.
    pub file: Located<PathBuf>,
    /// What stored colour means; absent: sRGB where a colour is wanted, linear where data is.
    pub transfer: Option<Transfer>,
}

/// Shared geometry.
#[derive(Clone, Debug)]
pub struct MeshRecord {
    /// Its name.
    pub name: String,
    /// Where the vertices are.
    pub source: MeshSource,
    /// Degrees, in (0, 180]: where normals are missing, edges less sharp than this are smoothed; absent: none are.
    pub crease_angle: Option<f64>,
    /// Fewer faces, before normals are made.
    pub simplify: Option<SimplifyRecord>,
    /// Where its name is.
    pub origin: Origin,
}

/// Where the vertices of a mesh are.
#[derive(Clone, Debug)]
pub enum MeshSource {
    /// In a file; relative to [`SceneDescription::folder`].
    File(Located<PathBuf>),
    /// Here.
    Inline(Mesh),
}

/// A thing in the scene.
#[derive(Clone, Debug)]
pub struct ObjectRecord {
    /// Its name, if it has one.
    pub name: Option<Located<String>>,
    /// Its geometry.
    pub shape: ShapeRecord,
    /// Name of its material; absent: the mesh file's own, or plain grey.
    pub material: Option<Located<String>>,
    /// Names of the mesh file's materials, and of those that stand in their places.
    pub materials: Vec<[Located<String>; 2]>,
    /// Applied in order.
    pub transform: Vec<Located<Step>>,
    /// How it moves from there; absent: not at all, or as keyframes or physics say.
    pub motion: Option<MotionRecord>,
    /// How it moves and collides; absent: it does neither.
    pub body: Option<BodyRecord>,
    /// Where the object is described.
    pub origin: Origin,
}

/// Geometry of an object, before its transform.
#[derive(Clone, Debug)]
pub enum ShapeRecord {
    /// A mesh of [`SceneDescription::meshes`].
    Mesh(Located<String>),
    /// A mesh file.
    File {
        /// Relative to [`SceneDescription::folder`].
        path: Located<PathBuf>,
        /// As [`MeshRecord::crease_angle`].
        crease_angle: Option<f64>,
        /// As [`MeshRecord::simplify`].
        simplify: Option<SimplifyRecord>,
    },
    /// A sphere.
    Sphere {
        /// Centre, metres.
        center: DVec3,
        /// Radius, metres.
        radius: f64,
    },
    /// A parallelogram `corner + a u + b v`; its normal is along `u` x `v`.
    Rectangle {
        /// Corner, metres.
        corner: DVec3,
        /// First edge, metres.
        u: DVec3,
        /// Second edge, metres.
        v: DVec3,
    },
    /// An axis-aligned box with its normals outward.
    Box {
        /// Lowest corner, metres.
        min: DVec3,
        /// Highest corner, metres.
        max: DVec3,
    },
    /// A regular polygon about the origin in the plane z = 0, its normal +z.
    Disk {
        /// Radius of the disk that has its area, metres.
        radius: f64,
        /// Its corners.
        segments: u32,
    },
}

/// One step of a transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Moves by a vector, metres.
    Translate(DVec3),
    /// Turns about an axis through the origin, right-handed.
    Rotate {
        /// Unit length.
        axis: DVec3,
        /// Degrees.
        angle: f64,
    },
    /// Stretches along the axes; no factor is 0.
    Scale(DVec3),
    /// An affine map, three rows of four.
    Matrix([f64; 12]),
    /// Puts the origin at `position` and turns +z towards `target`, +y as near to `up` as can be.
    LookAt {
        /// Metres.
        position: DVec3,
        /// Metres.
        target: DVec3,
        /// Any length but 0.
        up: DVec3,
    },
    /// Moves the lowest corner of the bounding box of the object, as transformed so far, to a point.
    Relocate(DVec3),
}
