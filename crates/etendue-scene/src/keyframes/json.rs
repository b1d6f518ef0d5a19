//! Poses in JSON, as `etendue simulate` writes them:
//! `{"format":"etendue-motion","version":1,"times":[...],"objects":[{"name":"ball","positions":[[x,y,z],...],"rotations":[[x,y,z,w],...]}]}`,
//! and if known `hash`, `step`, `interpolation` and `relative` of all, and `pivot` of an object.

use super::{Made, Recorded, Recording, check_count};
use crate::{Diagnostic, FileId, Span, track::Interpolation};
use etendue::{
    math::{DQuat, DVec3},
    motion::Pose,
};
use serde::{
    Deserialize, Deserializer,
    de::{Error, SeqAccess, Visitor},
};
use std::{fmt, sync::Arc};

/// Seconds and metres reach this far.
const FARTHEST: f64 = 1e15;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Form {
    #[serde(rename = "format")]
    _format: Format,
    #[serde(rename = "version")]
    _version: Version,
    hash: Option<String>,
    step: Option<Step>,
    interpolation: Option<Between>,
    relative: Option<bool>,
    times: Times,
    objects: Vec<FormObject>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FormObject {
    name: String,
    pivot: Option<Position>,
    positions: Vec<Position>,
    rotations: Vec<Rotation>,
}

struct Format;

impl<'de> Deserialize<'de> for Format {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        match &String::deserialize(from)?[..] {
            "etendue-motion" => Ok(Self),
            other => Err(D::Error::custom(format!("the format is `{other}`, expected `etendue-motion`"))),
        }
    }
}

struct Version;

impl<'de> Deserialize<'de> for Version {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        match u64::deserialize(from)? {
            1 => Ok(Self),
            other => Err(D::Error::custom(format!("version {other} of the format is not known, only 1 is"))),
        }
    }
}

/// Seconds, above 0.
struct Step(f64);

impl<'de> Deserialize<'de> for Step {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let step = f64::deserialize(from)?;
        let is_step = step > 0.0 && step.is_finite();
        is_step.then_some(Self(step)).ok_or_else(|| D::Error::custom("expected seconds above 0"))
    }
}

struct Between(Interpolation);

impl<'de> Deserialize<'de> for Between {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let name = String::deserialize(from)?;
        let found = Interpolation::ALL.into_iter().find(|way| way.name() == name);
        found.map(Self).ok_or_else(|| D::Error::custom("expected `linear`, `slerp` or `cubic`"))
    }
}

/// Strictly ascending.
struct Times(Vec<f64>);

impl<'de> Deserialize<'de> for Times {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Ascending;
        impl<'de> Visitor<'de> for Ascending {
            type Value = Times;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an array of ascending times")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut from: A) -> Result<Times, A::Error> {
                let mut times: Vec<f64> = Vec::new();
                while let Some(time) = from.next_element::<f64>()? {
                    if time.abs() > FARTHEST {
                        return Err(A::Error::custom("the time is too far from 0"));
                    }
                    if let Some(before) = times.last().filter(|before| time <= **before) {
                        let message = format!("times must be ascending, but {time} follows {before}");
                        return Err(A::Error::custom(message));
                    }
                    times.push(time);
                }
                if times.is_empty() {
                    return Err(A::Error::custom("there are no times"));
                }
                Ok(Times(times))
            }
        }
        from.deserialize_seq(Ascending)
    }
}

struct Position(DVec3);

impl<'de> Deserialize<'de> for Position {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let position = DVec3::from_array(<[f64; 3]>::deserialize(from)?);
        if position.abs().max_element() > FARTHEST {
            return Err(D::Error::custom("the position is too far away"));
        }
        Ok(Self(position))
    }
}

struct Rotation(DQuat);

impl<'de> Deserialize<'de> for Rotation {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let rotation = DQuat::from_array(<[f64; 4]>::deserialize(from)?);
        let length = rotation.length();
        if (length - 1.0).abs() > 1e-2 {
            return Err(D::Error::custom(format!(
                "a rotation is a unit quaternion [x, y, z, w], but this has length {length}"
            )));
        }
        // What is a unit quaternion to the last bits stays as it is.
        Ok(Self(if (length - 1.0).abs() < 4.0 * f64::EPSILON { rotation } else { rotation.normalize() }))
    }
}

pub(super) fn read(file: FileId, bytes: &[u8]) -> Result<Recording, Diagnostic> {
    let form: Form = serde_json::from_slice(bytes).map_err(|error| {
        let at = offset(bytes, error.line(), error.column());
        let message = error.to_string();
        // The place is shown, and need not be told.
        let message = message.split(" at line ").next().unwrap_or_default().to_owned();
        Diagnostic::error(message).at(Span::new(file, at..at + 1))
    })?;
    let rows = form.times.0.len();
    let whole = Span::new(file, 0..0);
    check_count(rows as u64, form.objects.len() as u64).map_err(|error| Diagnostic::error(error).at(whole))?;
    let mut from = 0;
    let mut objects = Vec::with_capacity(form.objects.len());
    for FormObject { name, pivot, positions, rotations } in form.objects {
        let place = place_of(file, bytes, &name, &mut from);
        for (what, count) in [("positions", positions.len()), ("rotations", rotations.len())] {
            if count != rows {
                let message = format!("`{name}` has {count} {what}, but there are {rows} times");
                return Err(Diagnostic::error(message).at(place));
            }
        }
        let pair =
            |(position, rotation): (&Position, &Rotation)| Pose { rotation: rotation.0, translation: position.0 };
        let poses = positions.iter().zip(&rotations).map(pair).collect();
        objects.push(Recorded { name: Some(name), place, poses, pivot: pivot.map(|pivot| pivot.0) });
    }
    Ok(Recording {
        made: Made {
            hash: form.hash.map(|hash| (hash.clone(), place_of(file, bytes, &hash, &mut 0))),
            step: form.step.map(|step| step.0),
            rows,
        },
        times: Some(Arc::from(form.times.0)),
        interpolation: form.interpolation.map(|way| way.0),
        relative: form.relative.unwrap_or(true),
        objects,
        file,
    })
}

/// Where the column of a line is; both count from 1.
fn offset(bytes: &[u8], line: usize, column: usize) -> usize {
    let mut starts =
        std::iter::once(0).chain(bytes.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(i, _)| i + 1));
    let start = starts.nth(line.saturating_sub(1)).unwrap_or(bytes.len());
    (start + column.saturating_sub(1)).min(bytes.len())
}

/// Where a name stands, after those before it; the start of the file if it, or one before it, is not written plainly.
fn place_of(file: FileId, bytes: &[u8], name: &str, from: &mut usize) -> Span {
    let quoted = format!("\"{name}\"");
    let found = bytes[*from..].windows(quoted.len()).position(|window| window == quoted.as_bytes());
    match found {
        Some(at) => {
            let start = *from + at;
            *from = start + quoted.len();
            Span::new(file, start..*from)
        }
        None => {
            *from = bytes.len();
            Span::new(file, 0..0)
        }
    }
}
