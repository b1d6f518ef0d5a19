//! Textures that are computed: functions of a point, and of the box about it that they are the mean over.

mod cells;
mod gradient;
mod lattice;
mod marble;
mod noise;
mod periodic;
mod wood;

pub use cells::{Checker, Grid};
pub use gradient::{Gradient, Stop};
pub use marble::Marble;
pub use noise::{MAX_OCTAVES, Noise};
pub use wood::Wood;

use super::{Lookup, UvTransform};
use crate::math::{Vec2, Vec3, vec2};

/// What a procedure is a function of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coordinates {
    /// Texture coordinates, transformed as those of images.
    Uv,
    /// The point in the object's own space, metres, times `scale`, plus `offset`: a solid texture, without seams.
    Object {
        /// Cells a metre, along each axis.
        scale: Vec3,
        /// Cells.
        offset: Vec3,
    },
}

/// A point in a procedure's own space, where its cells are 1 wide, and the ellipse about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub point: Vec3,
    /// Whole axes of the footprint.
    pub axes: [Vec3; 2],
    /// The last coordinate means something.
    pub is_solid: bool,
}

impl Place {
    /// Whole extent of the footprint along a direction.
    #[inline]
    pub fn extent(&self, direction: Vec3) -> f32 {
        let [a, b] = self.axes.map(|axis| axis.dot(direction));
        (a * a + b * b).sqrt()
    }

    /// Lengths of the footprint's axes.
    #[inline]
    pub fn widths(&self) -> [f32; 2] {
        self.axes.map(Vec3::length)
    }
}

impl Coordinates {
    pub(super) fn place(&self, transform: &UvTransform, at: &Lookup) -> Place {
        let finite = |v: Vec3| if v.is_finite() { v } else { Vec3::ZERO };
        match *self {
            Self::Uv => Place {
                point: finite(transform.apply(at.uv).extend(0.0)),
                axes: at.footprint.uv.map(|axis| finite(transform.linear(axis).extend(0.0))),
                is_solid: false,
            },
            Self::Object { scale, offset } => Place {
                point: finite(at.position * scale + offset),
                axes: at.footprint.position.map(|axis| finite(axis * scale)),
                is_solid: true,
            },
        }
    }

    /// How far one has to go along u and v to move by 1 in the procedure's space; infinite where that leads nowhere.
    pub(super) fn steps(&self, transform: &UvTransform, at: &Lookup) -> Vec2 {
        let speed = match *self {
            Self::Uv => transform.scale(),
            Self::Object { scale, .. } => {
                let [u, v] = at.tangents.map(|tangent| (tangent * scale).length());
                vec2(u, v)
            }
        };
        let step = |speed: f32| if speed > 0.0 { 1.0 / speed } else { f32::INFINITY };
        vec2(step(speed.x), step(speed.y))
    }
}

/// What every procedure does.
trait Function {
    /// A number in [0, 1] at a place, as the mean over its footprint where there is one.
    fn value(&self, place: &Place) -> f32;
    /// A step that is fine enough to take slopes over, cells.
    fn finest(&self) -> f32;
}

/// Brought into [0, 1]; what is not a number, as where a sum overflows, is 0.
#[inline]
pub(super) fn in_unit(x: f32) -> f32 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}

/// A function of a point, with values in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Procedure {
    /// Squares or cubes in turn.
    Checker(Checker),
    /// Lines or planes between cells.
    Grid(Grid),
    /// Clouds.
    Noise(Noise),
    /// Rings about an axis.
    Wood(Wood),
    /// Veins across an axis.
    Marble(Marble),
}

macro_rules! dispatch {
    ($procedure:expr, $p:ident => $call:expr) => {
        match $procedure {
            Procedure::Checker($p) => $call,
            Procedure::Grid($p) => $call,
            Procedure::Noise($p) => $call,
            Procedure::Wood($p) => $call,
            Procedure::Marble($p) => $call,
        }
    };
}

impl Procedure {
    /// Every procedure, with default parameters.
    pub const ALL: [Self; 5] = [
        Self::Checker(Checker),
        Self::Grid(Grid::DEFAULT),
        Self::Noise(Noise::DEFAULT),
        Self::Wood(Wood::DEFAULT),
        Self::Marble(Marble::DEFAULT),
    ];

    /// The name it has in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Checker(_) => "checker",
            Self::Grid(_) => "grid",
            Self::Noise(_) => "noise",
            Self::Wood(_) => "wood",
            Self::Marble(_) => "marble",
        }
    }

    pub(super) fn value(&self, place: &Place) -> f32 {
        in_unit(dispatch!(self, p => p.value(place)))
    }

    pub(super) fn finest(&self) -> f32 {
        dispatch!(self, p => p.finest())
    }
}
