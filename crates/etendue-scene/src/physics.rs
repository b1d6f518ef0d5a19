//! What a scene file says of rigid bodies: how they move and touch, and what joins them. Nothing is simulated here.

use crate::{Origin, description::Located};
use etendue::math::DVec3;

/// Physical properties of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyRecord {
    /// What may move it.
    pub kind: BodyKind,
    /// How heavy it is.
    pub mass: Mass,
    /// Coulomb's coefficient; of two bodies that touch, the scene's rule makes one.
    pub friction: f64,
    /// Speed after a collision over speed before, in [0, 1]; of two bodies, the scene's rule makes one.
    pub restitution: f64,
    /// Of the centre of mass at the start, m/s.
    pub linear_velocity: DVec3,
    /// About the axes of the world at the start, degrees/s.
    pub angular_velocity: DVec3,
    /// Share of the velocity that is lost a second, 1/s.
    pub linear_damping: f64,
    /// Share of the rotation that is lost a second, 1/s.
    pub angular_damping: f64,
    /// Multiplies gravity.
    pub gravity_scale: f64,
    /// What collides.
    pub shape: CollisionShape,
    /// Name of the group that [`PhysicsRecord::ignore`] knows it by.
    pub group: Option<Located<String>>,
    /// Where it is described.
    pub origin: Origin,
}

impl BodyRecord {
    /// A body with all properties at their defaults.
    pub fn new(kind: BodyKind, origin: Origin) -> Self {
        Self {
            kind,
            mass: Mass::Density(1000.0),
            friction: 0.5,
            restitution: 0.0,
            linear_velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            linear_damping: 0.0,
            angular_damping: 0.0,
            gravity_scale: 1.0,
            shape: CollisionShape::Auto,
            group: None,
            origin,
        }
    }
}

/// What may move a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyKind {
    /// Forces.
    Dynamic,
    /// Nothing.
    Fixed,
    /// Its keys: it pushes others and is never pushed.
    Kinematic,
}

impl BodyKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Dynamic, Self::Fixed, Self::Kinematic];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dynamic => "dynamic",
            Self::Fixed => "fixed",
            Self::Kinematic => "kinematic",
        }
    }
}

/// How heavy a body is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mass {
    /// Altogether, kg.
    Total(f64),
    /// Of its volume, kg/m³.
    Density(f64),
}

/// What stands for an object where bodies touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CollisionShape {
    /// The closest that is fast: spheres and boxes as they are, convex hulls of what is convex, triangles of what is never pushed, convex
    /// pieces of the rest.
    #[default]
    Auto,
    /// A sphere about the middle of the bounding box that holds the object.
    Sphere,
    /// The bounding box, along the axes that the object has before its transform.
    Box,
    /// The convex hull.
    Hull,
    /// Its triangles.
    Mesh,
    /// Convex pieces.
    Decomposed,
}

impl CollisionShape {
    /// All shapes.
    pub const ALL: [Self; 6] = [Self::Auto, Self::Sphere, Self::Box, Self::Hull, Self::Mesh, Self::Decomposed];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Sphere => "sphere",
            Self::Box => "box",
            Self::Hull => "hull",
            Self::Mesh => "mesh",
            Self::Decomposed => "decomposed",
        }
    }
}

/// How the coefficients of two bodies become one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Combine {
    /// Half of the sum.
    Average,
    /// The smaller.
    Min,
    /// The product.
    Multiply,
    /// The larger.
    Max,
    /// The root of the product.
    GeometricMean,
}

impl Combine {
    /// All rules.
    pub const ALL: [Self; 5] = [Self::Average, Self::Min, Self::Multiply, Self::Max, Self::GeometricMean];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Average => "average",
            Self::Min => "min",
            Self::Multiply => "multiply",
            Self::Max => "max",
            Self::GeometricMean => "geometric-mean",
        }
    }
}

/// `[physics]`: what holds for all bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct PhysicsRecord {
    /// m/s².
    pub gravity: DVec3,
    /// Seconds from one recorded pose to the next.
    pub step: f64,
    /// Parts of a step, each of which moves bodies and solves contacts.
    pub substeps: u32,
    /// Rounds over all contacts and joints in a part.
    pub iterations: u32,
    /// Seconds of scene time at which bodies are where the scene file puts them.
    pub start: f64,
    /// Seconds that are simulated; absent: as long as the animation needs, or 10.
    pub duration: Option<f64>,
    /// Seconds that are simulated before [`Self::start`] and not recorded.
    pub warm_up: f64,
    /// Of two coefficients of friction.
    pub friction_rule: Combine,
    /// Of two coefficients of restitution.
    pub restitution_rule: Combine,
    /// Typical size of bodies, metres, that tolerances follow; absent: the median of the moving bodies' diameters.
    pub length_unit: Option<f64>,
    /// How fast overlaps are pushed apart: natural frequency of the contact's spring, Hz.
    pub contact_frequency: f64,
    /// Its damping ratio.
    pub contact_damping: f64,
    /// Bodies that rest for half a second stop being simulated until they are touched.
    pub sleep: bool,
    /// Pairs of groups whose bodies do not collide.
    pub ignore: Vec<[Located<String>; 2]>,
    /// Where the table is; absent: it is not there.
    pub origin: Option<Origin>,
}

impl Default for PhysicsRecord {
    fn default() -> Self {
        Self {
            gravity: DVec3::new(0.0, -9.81, 0.0),
            step: 1.0 / 480.0,
            substeps: 4,
            iterations: 1,
            start: 0.0,
            duration: None,
            warm_up: 0.0,
            friction_rule: Combine::GeometricMean,
            restitution_rule: Combine::Max,
            length_unit: None,
            contact_frequency: 60.0,
            contact_damping: 10.0,
            sleep: true,
            ignore: Vec::new(),
            origin: None,
        }
    }
}

/// One of `[[joints]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct JointRecord {
    /// What it leaves free.
    pub kind: JointKind,
    /// The objects that it joins; the second absent: the world.
    pub bodies: (Located<String>, Option<Located<String>>),
    /// Where they are joined, a point of the world at the start, metres.
    pub anchor: DVec3,
    /// About or along what they move, in the world at the start; of unit length.
    pub axis: DVec3,
    /// How far they move: degrees or metres away from the start.
    pub limits: Option<[f64; 2]>,
    /// What drives it.
    pub motor: Option<MotorRecord>,
    /// The two bodies also collide.
    pub collide: bool,
    /// Where it is described.
    pub origin: Origin,
}

/// What a joint leaves free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Rotation about an axis.
    Hinge,
    /// Rotation.
    Ball,
    /// Motion along an axis.
    Slider,
    /// Nothing.
    Fixed,
}

impl JointKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Hinge, Self::Ball, Self::Slider, Self::Fixed];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hinge => "hinge",
            Self::Ball => "ball",
            Self::Slider => "slider",
            Self::Fixed => "fixed",
        }
    }
}

/// What drives a hinge or slider: the force `stiffness (position - x) + damping (velocity - v)` along or torque about its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorRecord {
    /// Degrees/s or m/s of the second body (or the world) against which the first moves.
    pub velocity: f64,
    /// Degrees or metres away from the start.
    pub position: f64,
    /// N/m or N m/rad.
    pub stiffness: f64,
    /// N s/m or N m s/rad.
    pub damping: f64,
    /// N or N m; absent: no limit.
    pub max_force: Option<f64>,
}
