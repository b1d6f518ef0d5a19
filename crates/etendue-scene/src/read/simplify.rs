//! `simplify` of a mesh.

use super::{
    fields::{Fields, Item},
    keys,
    values::Bounds,
};
use crate::{
    simplify::{Goal, METHODS, PLACEMENTS, SimplifyRecord},
    value::Data,
};
use etendue_simplify::Placement;

/// Faces that can be asked for.
pub const FACES: (i64, i64) = (0, u32::MAX as i64);
/// Fractions of the faces.
pub const RATIO: Bounds = Bounds::within(0.0, 1.0).above();
/// Deviations of positions over the local edge length.
pub const SIGMAS: Bounds = Bounds::within(0.0, 1.0);

/// How to simplify; an error has been reported if `None`.
pub fn simplify(item: Item) -> Option<SimplifyRecord> {
    let fields = item.table(&keys::SIMPLIFY, "{ faces = 10000 }")?;
    let goal = goal(&fields);
    let sigma = fields.read("sigma", |i| i.number(SIGMAS));
    let placement = fields.read("placement", |i| i.choice(&PLACEMENTS));
    let record = SimplifyRecord {
        goal: goal.unwrap_or(Goal::Ratio(1.0)),
        method: fields.read("method", |i| i.choice(&METHODS)).unwrap_or_default(),
        placement: with_sigma(&fields, placement, sigma),
        keep_boundary: fields.read("keep_boundary", |i| i.boolean()).unwrap_or(false),
        crease_angle: fields.read("crease_angle", |i| i.number(Bounds::within(0.0, 180.0).above())),
        fast: fields.read("fast", |i| i.boolean()).unwrap_or(false),
        polish: fields.read("polish", |i| i.boolean()).unwrap_or(true),
        seed: fields.read("seed", |i| i.integer(0, i64::MAX)).unwrap_or(0) as u64,
        origin: item.value.origin.clone(),
    };
    fields.finish();
    goal.map(|_| record)
}

fn goal(fields: &Fields) -> Option<Goal> {
    for (first, second) in [("faces", "ratio"), ("faces", "max_error"), ("ratio", "max_error")] {
        fields.exclusive(first, second);
    }
    let goals = [
        fields.read("faces", |i| i.integer(FACES.0, FACES.1)).map(|faces| Goal::Faces(faces as usize)),
        fields.read("ratio", |i| i.number(RATIO)).map(Goal::Ratio),
        fields.read("max_error", distance),
    ];
    if ["faces", "ratio", "max_error"].iter().all(|key| fields.get(key).is_none()) {
        fields.lacks("`faces`, `ratio` or `max_error`");
    }
    goals.into_iter().flatten().next()
}

/// A length, or percents of the diagonal.
fn distance(item: Item) -> Option<Goal> {
    let Data::String(text) = &item.value.data else { return item.number(Bounds::LENGTH).map(Goal::Error) };
    match Goal::of_distance(text) {
        Some(goal @ Goal::RelativeError(_)) => Some(goal),
        _ => item.error(format!("`{text}` is no distance"), "expected percents of the diagonal such as \"0.5%\""),
    }
}

/// `sigma` is of probabilistic placement alone.
fn with_sigma(fields: &Fields, placement: Option<Placement>, sigma: Option<f64>) -> Placement {
    match (placement, sigma) {
        (None | Some(Placement::Probabilistic { .. }), Some(sigma)) => Placement::Probabilistic { sigma },
        (Some(placement), Some(_)) => {
            fields.read("sigma", |i| i.error::<()>("`sigma` is for probabilistic placement", "leave it out"));
            placement
        }
        (placement, None) => placement.unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SourceMap, description::ShapeRecord, read_toml};
    use etendue_simplify::Method;
    use std::path::Path;

    fn read(simplify: &str) -> Result<SimplifyRecord, Vec<String>> {
        let text = format!(
            "camera = {{ position = [0, 0, 5], look_at = [0, 0, 0] }}\n[[objects]]\nfile = \"a.obj\"\nsimplify = {simplify}"
        );
        let mut sources = SourceMap::new();
        let file = sources.insert("s.toml", text.clone().into_bytes()).unwrap();
        let (description, found) = read_toml(file, text.as_bytes(), Path::new(""));
        match description.map(|mut d| d.objects.remove(0).shape) {
            Some(ShapeRecord::File { simplify, .. }) => Ok(simplify.unwrap()),
            _ => Err(found.iter().map(|d| d.one_line(&sources)).collect()),
        }
    }

    #[test]
    fn goals_and_options() {
        assert_eq!(read("{ faces = 1000 }").unwrap().goal, Goal::Faces(1000));
        assert_eq!(read("{ ratio = 0.25 }").unwrap().goal, Goal::Ratio(0.25));
        assert_eq!(read("{ max_error = 0.02 }").unwrap().goal, Goal::Error(0.02));
        assert_eq!(read("{ max_error = \"0.5%\" }").unwrap().goal, Goal::RelativeError(0.005));
        let record = read(
            "{ faces = 9, method = \"quadric-union\", sigma = 0.5, keep_boundary = true, crease_angle = 30, fast = true, \
             polish = false, seed = 7 }",
        )
        .unwrap();
        assert_eq!((record.method, record.placement), (Method::QuadricUnion, Placement::Probabilistic { sigma: 0.5 }));
        assert_eq!((record.keep_boundary, record.fast, record.polish), (true, true, false));
        assert_eq!((record.crease_angle, record.seed), (Some(30.0), 7));
        assert_eq!(read("{ faces = 9, placement = \"midpoint\" }").unwrap().placement, Placement::Midpoint);
        assert_eq!(read("{ faces = 9 }").unwrap().placement, Placement::Auto);
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, part) in [
            ("{ }", "`faces`, `ratio` or `max_error`"),
            ("{ faces = 1, ratio = 0.5 }", "exclude each other"),
            ("{ faces = -1 }", "faces"),
            ("{ ratio = 0 }", "ratio"),
            ("{ ratio = 1.5 }", "ratio"),
            ("{ max_error = 0 }", "max_error"),
            ("{ max_error = \"1\" }", "no distance"),
            ("{ max_error = \"-1%\" }", "no distance"),
            ("{ faces = 9, method = \"?\" }", "method"),
            ("{ faces = 9, placement = \"endpoint\", sigma = 0.1 }", "probabilistic placement"),
            ("{ faces = 9, crease_angle = 0 }", "crease_angle"),
            ("{ faces = 9, passes = 3 }", "unknown key `passes`"),
            ("9", "must be a table"),
        ] {
            let found = read(text).unwrap_err();
            assert!(found.iter().any(|line| line.contains(part)), "{text}: {found:?}");
        }
    }
}
