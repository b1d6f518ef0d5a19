//! Where the camera of an automatic scene stands.

use super::survey::{Model, Survey};
use glam::DVec3;

/// Field of view across the longer side of the picture, degrees.
pub const FOV: f64 = 30.0;
/// The same from inside a closed room.
pub const FOV_INSIDE: f64 = 75.0;
/// Part of the picture that the model fills, of its tighter side.
const FILL: f64 = 0.86;
/// The same for a room that is looked into.
const FILL_ROOM: f64 = 0.99;

/// Where a model is looked at from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelView {
    /// Along -z, level.
    Front,
    /// Along -x, level.
    Side,
    /// Along -y, with -z up in the picture.
    Top,
    /// Three quarters: from the front, the right and a little above.
    Iso,
}

impl ModelView {
    /// Every view.
    pub const ALL: [Self; 4] = [Self::Front, Self::Side, Self::Top, Self::Iso];

    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Side => "side",
            Self::Top => "top",
            Self::Iso => "iso",
        }
    }

    fn direction(self) -> DVec3 {
        match self {
            Self::Front => DVec3::Z,
            Self::Side => DVec3::X,
            Self::Top => DVec3::Y,
            Self::Iso => DVec3::new(0.52, 0.42, 0.82).normalize(),
        }
    }
}

/// A camera, and what is seen from there.
#[derive(Clone, Copy, Debug)]
pub struct Stand {
    /// Unit vector from the model to the camera.
    pub back: DVec3,
    /// Up in the picture.
    pub up: DVec3,
    /// Centre of projection.
    pub position: DVec3,
    /// What is in the middle of the picture.
    pub target: DVec3,
    /// Across the longer side of the picture, degrees.
    pub fov: f64,
    /// In words.
    pub words: &'static str,
}

/// Sides of a room that can be looked through, in the order they are tried: index into [`Survey::covered`], the direction
/// out of it, and two sizes of its opening, as axes.
const OPEN_SIDES: [(usize, DVec3); 5] =
    [(5, DVec3::Z), (2, DVec3::NEG_Z), (3, DVec3::X), (0, DVec3::NEG_X), (4, DVec3::Y)];

/// What a lit model is seen through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Room {
    /// Not a room.
    No,
    /// Open on one side, in this direction.
    Open(DVec3),
    /// Closed all round.
    Closed,
}

impl Room {
    /// Whether the faces of a model make a room: along at least four sides of its bounding box.
    pub fn of(survey: &Survey) -> Self {
        const WALL: f64 = 0.6;
        let walls = survey.covered.iter().filter(|c| **c > WALL).count();
        if walls < 4 {
            return Self::No;
        }
        match OPEN_SIDES.iter().find(|(side, _)| survey.covered[*side] < 0.5 * WALL) {
            Some((_, out)) => Self::Open(*out),
            None => Self::Closed,
        }
    }

    /// Width over height of what is looked through.
    pub fn aspect(self, survey: &Survey) -> Option<f64> {
        let size = survey.size();
        match self {
            Self::Open(out) if out.y != 0.0 => Some(size.x / size.z),
            Self::Open(out) => Some((size.x * out.z.abs() + size.z * out.x.abs()) / size.y),
            _ => None,
        }
    }
}

/// Where to look at a model from, for a picture of `width` x `height`.
pub fn stand(model: &Model, survey: &Survey, view: Option<ModelView>, room: Room, size: [u32; 2]) -> Stand {
    if let Some(view) = view {
        return outside(model, survey, view.direction(), size, FILL, words(view));
    }
    match room {
        Room::Open(out) => outside(model, survey, out, size, FILL_ROOM, "into the open side of the room"),
        Room::Closed => inside(survey),
        Room::No => match survey.flat(model) {
            Some(normal) => outside(model, survey, before(normal), size, FILL, "before the flat model"),
            None => outside(model, survey, ModelView::Iso.direction(), size, FILL, words(ModelView::Iso)),
        },
    }
}

fn words(view: ModelView) -> &'static str {
    match view {
        ModelView::Front => "from the front",
        ModelView::Side => "from the side",
        ModelView::Top => "from above",
        ModelView::Iso => "from the front, the right and a little above",
    }
}

/// A little beside the normal of a flat model; from above if it lies on its face.
fn before(normal: DVec3) -> DVec3 {
    let normal = if normal.y < -0.5 { -normal } else { normal };
    if normal.y > 0.5 {
        return (normal + ModelView::Iso.direction() * 0.9).normalize();
    }
    let right = DVec3::Y.cross(normal);
    (normal + right * 0.3 + DVec3::Y * 0.2).normalize()
}

/// The nearest camera in the direction `back` that sees all of the model within `fill` of the picture, the model in its
/// middle.
///
/// A plane through the camera and an edge of the picture touches the model on each side. Two of them opposite each other give
/// the place of the camera across the view, in the middle, and its distance; the axis of the picture that asks for the larger
/// distance decides. On the other one the model fills less of the picture: how much follows from the distance, and is found
/// by a few rounds, each of which gives a better middle.
fn outside(model: &Model, survey: &Survey, back: DVec3, size: [u32; 2], fill: f64, words: &'static str) -> Stand {
    const ROUNDS: usize = 4;
    let up = if back.y.abs() > 0.999 { DVec3::NEG_Z } else { DVec3::Y };
    let right = up.cross(back).normalize();
    let axes = [right, back.cross(right)];
    let longer = f64::from(size[0].max(size[1]));
    let half = libm::tan((0.5 * FOV).to_radians()) * fill;
    // About the middle of the model, so that nothing is lost where it lies far away.
    let center = survey.center();
    let touch = |halves: [f64; 2]| {
        let [x, y] = std::array::from_fn(|i| [axes[i] + back * halves[i], back * halves[i] - axes[i]]);
        let sides = [x[0], x[1], y[0], y[1]];
        let reach = model.reach(&sides);
        let reach: [f64; 4] = std::array::from_fn(|i| reach[i] - sides[i].dot(center));
        [[reach[0], reach[1]], [reach[2], reach[3]]]
    };
    let mut halves = size.map(|side| half * f64::from(side) / longer);
    let mut reach = touch(halves);
    let asked = |i: usize| (reach[i][0] + reach[i][1]) / (2.0 * halves[i]);
    // Never in the model's plane: a model without depth along the view still has a distance.
    let distance = asked(0).max(asked(1)).max(1e-6 * survey.size().max_element());
    for _ in 0..ROUNDS {
        halves = reach.map(|[low, high]| (low + high) / (2.0 * distance));
        reach = touch(halves);
    }
    let across = axes[0] * (0.5 * (reach[0][0] - reach[0][1])) + axes[1] * (0.5 * (reach[1][0] - reach[1][1]));
    let target = center + across;
    Stand { back, up, position: target + back * distance, target, fov: FOV, words }
}

/// From one end of a closed room, at the height of eyes, along its longer side.
fn inside(survey: &Survey) -> Stand {
    let (center, size) = (survey.center(), survey.size());
    let back = if size.x > size.z { DVec3::X } else { DVec3::Z };
    let position = center + back * (0.46 * back.dot(size)) + DVec3::Y * (0.1 * size.y);
    let target = position - back * (0.5 * back.dot(size)) - DVec3::Y * (0.06 * size.y);
    Stand { back, up: DVec3::Y, position, target, fov: FOV_INSIDE, words: "inside the closed room" }
}
