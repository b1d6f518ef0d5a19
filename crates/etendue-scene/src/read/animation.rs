//! `[animation]`, and how objects move.

use super::{
    fields::{Fields, Item},
    keyed::TIME,
    keys, object, settings,
    values::Bounds,
};
use crate::{
    animation::{
        AnimationRecord, FrameRate, KeyframeTimes, KeyframesRecord, LengthRecord, MotionRecord, RotationRecord,
        rotation_about,
    },
    curve::{Blend, Curve},
    description::Located,
    track::{Interpolation, PoseTrack},
    value::Data,
};
use etendue::{
    math::{DQuat, DVec3},
    motion::{Pose, Shutter},
};

/// Scene seconds a second of film.
pub const SPEED: Bounds = Bounds::within(0.0, 1e6).above();
/// Frames or rows a second.
pub const FPS: Bounds = Bounds::within(FrameRate::RANGE.0, FrameRate::RANGE.1);
/// Rows a second of a file of poses.
pub const ROWS: Bounds = Bounds::within(0.0, 1e7).above();
/// Seconds.
pub const DURATION: Bounds = Bounds::within(0.0, 1e9).above();
/// Most frames.
pub const MAX_FRAMES: u32 = 1_000_000_000;
/// Fractions of the frame interval.
pub const SHUTTER: Bounds = Bounds::within(-1.0, 1.0);
/// Angles with keys, degrees.
const TURN: Bounds = Bounds::within(-1e6, 1e6);

/// `[animation]`.
pub fn animation(file: &Fields) -> AnimationRecord {
    let mut record = AnimationRecord::default();
    let Some(fields) = settings::section(file, "animation", &keys::ANIMATION) else { return record };
    record.start = fields.read("start", |i| i.number(TIME)).unwrap_or(record.start);
    record.speed = fields.read("speed", |i| i.number(SPEED)).unwrap_or(record.speed);
    record.fps = fields.read("fps", fps).unwrap_or(record.fps);
    fields.exclusive("frames", "duration");
    let frames = fields.read("frames", |i| i.integer_u32(1, MAX_FRAMES)).map(LengthRecord::Frames);
    record.length = fields.read("duration", |i| i.number(DURATION)).map(LengthRecord::Duration).or(frames);
    record.shutter = fields.read("shutter", shutter).unwrap_or(record.shutter);
    record.curve = fields.read("shutter_curve", curve).unwrap_or(record.curve);
    record.keyframes = fields.read("keyframes", keyframes);
    fields.finish();
    record
}

/// A number, or a fraction as text.
fn fps(item: Item) -> Option<FrameRate> {
    match &item.value.data {
        Data::String(text) => match text.parse() {
            Ok(rate) => Some(rate),
            Err(expected) => item.error(format!("`{text}` is no frame rate"), expected),
        },
        _ => FrameRate::of_number(item.number(FPS)?),
    }
}

/// `[open, close]`, or when it closes.
fn shutter(item: Item) -> Option<[f64; 2]> {
    let [open, close] = match item.value.data {
        Data::Array(_) => item.numbers(SHUTTER)?,
        _ => [0.0, item.number(Bounds::UNIT)?],
    };
    if close < open {
        return item.error("the shutter closes before it opens", "expected [open, close] with open <= close");
    }
    Some([open, close])
}

/// A name, or `[rise, fall]`.
fn curve(item: Item) -> Option<Shutter> {
    if let Data::Array(_) = item.value.data {
        let [rise, fall] = item.numbers(Bounds::UNIT)?;
        if rise + fall > 1.0 {
            return item.error("the shutter falls before it has risen", "expected [rise, fall] of at most 1 together");
        }
        return Some(Shutter::Trapezoid { rise, fall });
    }
    item.choice(&[("box", Shutter::Box), ("triangle", Shutter::Triangle)])
}

/// A file name, or a table that also says what is in the file.
fn keyframes(item: Item) -> Option<KeyframesRecord> {
    if !matches!(item.value.data, Data::Table(_)) {
        let file = object::path(item)?;
        return Some(KeyframesRecord { file, objects: None, times: None, interpolation: None, relative: None });
    }
    let fields = item.table(&keys::KEYFRAMES, "")?;
    let file = fields.need("file", object::path);
    let objects = fields.read("objects", |item| {
        let names: Vec<_> = item.array("an array of names of objects")?.filter_map(object::name).collect();
        Some(Located { value: names, origin: item.value.origin.clone() })
    });
    fields.exclusive("times", "start");
    fields.exclusive("times", "fps");
    let each = fields.read("times", times).map(KeyframeTimes::Each);
    let start = fields.read("start", |i| i.number(TIME));
    let fps = fields.read("fps", |i| i.number(ROWS));
    let steps = (start.is_some() || fps.is_some()).then_some(KeyframeTimes::Steps { start, fps });
    let names = Interpolation::ALL.map(|way| (way.name(), way));
    let interpolation = fields.read("interpolation", |i| i.choice(&names));
    let relative = fields.read("relative", |i| i.boolean());
    fields.finish();
    Some(KeyframesRecord { file: file?, objects, times: each.or(steps), interpolation, relative })
}

/// Times in order.
fn times(item: Item) -> Option<Located<Vec<f64>>> {
    let mut times: Vec<f64> = Vec::new();
    for time in item.array("an array of times")? {
        let seconds = time.number(TIME)?;
        if times.last().is_some_and(|before| seconds <= *before) {
            return time.error("times must be ascending", "not after the time before it");
        }
        times.push(seconds);
    }
    if times.is_empty() {
        return item.error("there are no times", "expected one for each row");
    }
    Some(Located { value: times, origin: item.value.origin.clone() })
}

/// The motion of an object.
pub fn motion(item: Item) -> Option<MotionRecord> {
    let fields = item.table(&keys::MOTION, "{ translate = { keys = [[0, [0, 0, 0]], [1, [2, 0, 0]]] } }")?;
    let translate = fields.get("translate").map(|item| item.curve_or(|item| item.plain_point()));
    let rotate = fields.get("rotate").map(rotation);
    let pivot = fields.read("pivot", |item| item.point());
    if translate.is_none() && rotate.is_none() {
        fields.lacks("`translate` or `rotate`");
    }
    fields.finish();
    if let Some(Some(Curve { blend: Blend::Step, .. })) = translate {
        return item.error("an object does not jump", "expected interpolation `linear` or `cubic`");
    }
    Some(MotionRecord {
        translate: translate.unwrap_or_else(|| Some(Curve::constant(DVec3::ZERO)))?,
        rotate: rotate.unwrap_or_else(|| Some(RotationRecord::none()))?,
        pivot,
        origin: item.value.origin.clone(),
    })
}

/// An axis and an angle that may have keys, or keys of rotations.
fn rotation(item: Item) -> Option<RotationRecord> {
    if item.is_keyed() {
        let ways = Interpolation::ALL.map(|way| (way.name(), way));
        let (keys, interpolation) = item.keys(one_rotation, &ways)?;
        let poses = keys.iter().map(|(_, rotation)| Pose { rotation: *rotation, translation: DVec3::ZERO }).collect();
        let times = keys.iter().map(|(time, _)| *time).collect();
        return Some(RotationRecord::Keys(PoseTrack::new(times, poses, interpolation)));
    }
    let fields = item.table(&keys::ROTATE, "{ axis = \"y\", angle = { keys = [[0, 0], [1, 90]] } }")?;
    let axis = fields.need("axis", |item| item.axis());
    let angle = fields.need("angle", |item| item.curve_or(|item| item.plain_number(TURN)));
    fields.finish();
    match angle {
        Some(Curve { blend: Blend::Step, .. }) => {
            item.error("an object does not jump", "expected interpolation `linear` or `cubic`")
        }
        angle => Some(RotationRecord::About { axis: axis?, angle: angle? }),
    }
}

/// `{ axis, angle }`, or the quaternion `[x, y, z, w]`.
fn one_rotation(item: Item) -> Option<DQuat> {
    if let Data::Array(_) = item.value.data {
        let numbers: [f64; 4] = item.numbers(Bounds::within(-2.0, 2.0))?;
        let q = DQuat::from_array(numbers);
        if (q.length() - 1.0).abs() > 1e-2 {
            return item.error("this is no unit quaternion", "expected [x, y, z, w] of length 1");
        }
        return Some(q.normalize());
    }
    let fields = item.table(&keys::ROTATE, "{ axis = \"y\", angle = 30 }, or [x, y, z, w]")?;
    let axis = fields.need("axis", |item| item.axis());
    let angle = fields.need("angle", |item| item.plain_number(TURN));
    fields.finish();
    Some(rotation_about(axis?, angle?))
}
