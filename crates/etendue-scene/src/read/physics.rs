//! `[physics]`, `body` of objects and `[[joints]]`.

use super::{
    error_at,
    fields::{Context, Item},
    keys,
    object::name,
    values::Bounds,
};
use crate::{
    description::{Located, ObjectRecord, SceneDescription},
    diagnostic::nearest,
    physics::{
        BodyKind, BodyRecord, CollisionShape, Combine, JointKind, JointRecord, Mass, MotorRecord, PhysicsRecord,
    },
    value::Data,
};
use etendue::math::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// Masses, kg, and densities, kg/m³.
pub const MASSES: Bounds = Bounds::within(1e-15, 1e20);
/// Speeds and accelerations, m/s or degrees/s.
pub const SPEEDS: Bounds = Bounds::within(-1e9, 1e9);
/// Coefficients of friction.
pub const FRICTIONS: Bounds = Bounds::within(0.0, 1e3);
/// Damping, stiffness and forces.
pub const FORCES: Bounds = Bounds::within(0.0, 1e20);
/// Lengths of steps, s.
pub const STEPS: Bounds = Bounds::within(1e-6, 1.0);
/// Lengths of simulations, s.
pub const DURATIONS: Bounds = Bounds::within(0.0, 1e6);
/// Scene times, s.
pub const TIMES: Bounds = Bounds::within(-1e6, 1e6);
/// Parts of steps, and rounds in them.
pub const PARTS: (u32, u32) = (1, 100);
/// Typical sizes, m.
pub const SIZES: Bounds = Bounds::within(1e-9, 1e9);
/// Frequencies of contacts, Hz.
pub const FREQUENCIES: Bounds = Bounds::within(0.1, 1e6);
/// Damping ratios of contacts.
pub const RATIOS: Bounds = Bounds::within(0.01, 1e3);
/// Groups that `ignore` may tell apart.
pub const MAX_GROUPS: usize = 31;
/// Pairs of groups.
pub const MAX_IGNORED: usize = MAX_GROUPS * (MAX_GROUPS + 1) / 2;

fn vector(item: Item) -> Option<DVec3> {
    item.numbers(SPEEDS).map(DVec3::from_array)
}

/// `body` of an object: a table, or its kind alone.
pub fn body(item: Item) -> Option<BodyRecord> {
    let kinds = BodyKind::ALL.map(|kind| (kind.name(), kind));
    if let Data::String(_) = item.value.data {
        return item.choice(&kinds).map(|kind| BodyRecord::new(kind, item.value.origin.clone()));
    }
    let mut fields = item.table(&keys::BODY, "\"fixed\", or { kind = \"dynamic\", restitution = 0.5 }")?;
    let kind = fields.variant("kind", &kinds, Some("dynamic"));
    let mut record = BodyRecord::new(kind.unwrap_or(BodyKind::Dynamic), item.value.origin.clone());
    fields.exclusive("mass", "density");
    if let Some(density) = fields.read("density", |i| i.number(MASSES)) {
        record.mass = Mass::Density(density);
    }
    if let Some(mass) = fields.read("mass", |i| i.number(MASSES)) {
        record.mass = Mass::Total(mass);
    }
    let number = |key: &str, value: &mut f64, bounds| {
        *value = fields.read(key, |i: Item| i.number(bounds)).unwrap_or(*value);
    };
    number("friction", &mut record.friction, FRICTIONS);
    number("restitution", &mut record.restitution, Bounds::UNIT);
    number("linear_damping", &mut record.linear_damping, FORCES);
    number("angular_damping", &mut record.angular_damping, FORCES);
    number("gravity_scale", &mut record.gravity_scale, SPEEDS);
    record.linear_velocity = fields.read("linear_velocity", vector).unwrap_or_default();
    record.angular_velocity = fields.read("angular_velocity", vector).unwrap_or_default();
    let shapes = CollisionShape::ALL.map(|shape| (shape.name(), shape));
    record.shape = fields.read("shape", |i| i.choice(&shapes)).unwrap_or_default();
    record.group = fields.read("group", name);
    fields.finish();
    kind.map(|_| record)
}

/// `[physics]`.
pub fn physics(item: Item) -> Option<PhysicsRecord> {
    let fields = item.table(&keys::PHYSICS, "[physics]")?;
    let mut record = PhysicsRecord { origin: Some(item.value.origin.clone()), ..PhysicsRecord::default() };
    let number = |key: &str, value: &mut f64, bounds| {
        *value = fields.read(key, |i: Item| i.number(bounds)).unwrap_or(*value);
    };
    number("step", &mut record.step, STEPS);
    number("start", &mut record.start, TIMES);
    number("warm_up", &mut record.warm_up, DURATIONS);
    number("contact_frequency", &mut record.contact_frequency, FREQUENCIES);
    number("contact_damping", &mut record.contact_damping, RATIOS);
    record.gravity = fields.read("gravity", vector).unwrap_or(record.gravity);
    record.duration = fields.read("duration", |i| i.number(DURATIONS));
    record.length_unit = fields.read("length_unit", |i| i.number(SIZES));
    let parts = |key: &str| fields.read(key, |i: Item| i.integer_u32(PARTS.0, PARTS.1));
    record.substeps = parts("substeps").unwrap_or(record.substeps);
    record.iterations = parts("iterations").unwrap_or(record.iterations);
    let rules = Combine::ALL.map(|rule| (rule.name(), rule));
    record.friction_rule = fields.read("friction_rule", |i| i.choice(&rules)).unwrap_or(record.friction_rule);
    record.restitution_rule = fields.read("restitution_rule", |i| i.choice(&rules)).unwrap_or(record.restitution_rule);
    record.sleep = fields.read("sleep", |i| i.boolean()).unwrap_or(record.sleep);
    record.ignore = fields.read("ignore", ignore).unwrap_or_default();
    fields.finish();
    Some(record)
}

/// Pairs of names of groups.
fn ignore(item: Item) -> Option<Vec<[Located<String>; 2]>> {
    let pairs = item.array_help("an array of pairs of groups", "[[\"dust\", \"dust\"], [\"dust\", \"walls\"]]")?;
    if pairs.len() > MAX_IGNORED {
        return item.error(format!("more than {MAX_IGNORED} pairs"), "too many");
    }
    Some(pairs.filter_map(|pair| pair.fixed("the names of two groups", name)).collect())
}

/// One of `[[joints]]`.
pub fn joint(item: Item) -> Option<JointRecord> {
    let mut fields = item.table(&keys::JOINT, "[[joints]]")?;
    let kinds = JointKind::ALL.map(|kind| (kind.name(), kind));
    let kind = fields.variant("type", &kinds, None);
    let bodies = fields.need("bodies", |i| bodies(&i));
    let anchor = fields.need("anchor", |i| i.point());
    let moves = matches!(kind, Some(JointKind::Hinge | JointKind::Slider));
    let axis = if moves { fields.need("axis", |i| i.axis()) } else { Some(DVec3::X) };
    let limits = if moves { fields.read("limits", limits) } else { None };
    let motor = if moves { fields.read("motor", motor) } else { None };
    let collide = fields.read("collide", |i| i.boolean()).unwrap_or(false);
    let origin = item.value.origin.clone();
    fields.finish();
    Some(JointRecord { kind: kind?, bodies: bodies?, anchor: anchor?, axis: axis?, limits, motor, collide, origin })
}

/// One name, or two.
fn bodies(item: &Item) -> Option<(Located<String>, Option<Located<String>>)> {
    let Data::Array(_) = item.value.data else { return name(*item).map(|first| (first, None)) };
    let names: Vec<_> = item.array("names of objects")?.map(name).collect();
    match <[_; 2]>::try_from(names) {
        Ok([first, second]) => {
            let (first, second) = (first?, second?);
            if first.value == second.value {
                return item.error("a joint joins two bodies", "expected another one, or one name for the world");
            }
            Some((first, Some(second)))
        }
        Err(mut names) if names.len() == 1 => Some((names.remove(0)?, None)),
        Err(names) => item
            .error(format!("`bodies` has {} names", names.len()), "expected two names, or one to join it to the world"),
    }
}

fn limits(item: Item) -> Option<[f64; 2]> {
    let [low, high] = item.numbers(Bounds::COORDINATE)?;
    if low > high {
        return item.error(format!("`limits` from {low} to {high} are empty"), "expected [lowest, highest]");
    }
    Some([low, high])
}

fn motor(item: Item) -> Option<MotorRecord> {
    let fields = item.table(&keys::MOTOR, "{ velocity = 90, damping = 10 }")?;
    let number = |key: &str, bounds| fields.read(key, |i: Item| i.number(bounds));
    let record = MotorRecord {
        velocity: number("velocity", SPEEDS).unwrap_or(0.0),
        position: number("position", SPEEDS).unwrap_or(0.0),
        stiffness: number("stiffness", FORCES).unwrap_or(0.0),
        damping: number("damping", FORCES).unwrap_or(0.0),
        max_force: number("max_force", FORCES),
    };
    if record.stiffness == 0.0 && record.damping == 0.0 {
        fields.lacks("`stiffness` or `damping`");
    }
    fields.finish();
    Some(record)
}

/// Names of joints' bodies and of groups.
pub fn check(cx: &Context, description: &SceneDescription) {
    let named = description.objects.iter().filter_map(|object| Some((object.name.as_ref()?.value.as_str(), object)));
    let named: BTreeMap<&str, &ObjectRecord> = named.collect();
    for joint in &description.joints {
        check_joint(cx, joint, &named);
    }
    let groups = description.objects.iter().filter_map(|object| object.body.as_ref()?.group.as_ref());
    let mut known = BTreeSet::new();
    for group in groups {
        if known.insert(group.value.as_str()) && known.len() == MAX_GROUPS + 1 {
            cx.push(error_at(format!("more than {MAX_GROUPS} groups of bodies"), &group.origin));
        }
    }
    for group in description.physics.ignore.iter().flatten() {
        if !known.contains(group.value.as_str()) {
            let error = error_at(format!("no body is of group `{}`", group.value), &group.origin);
            cx.missing(error.suggest(&group.value, known.iter().copied()));
        }
    }
}

fn check_joint(cx: &Context, joint: &JointRecord, named: &BTreeMap<&str, &ObjectRecord>) {
    let names = [Some(&joint.bodies.0), joint.bodies.1.as_ref()];
    let mut moves = false;
    for name in names.into_iter().flatten() {
        let Some(object) = named.get(name.value.as_str()) else {
            let error = error_at(format!("no object is called `{}`", name.value), &name.origin);
            let near = nearest(&name.value, named.keys().copied());
            cx.missing(match near {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => error.help("give the object a `name`"),
            });
            return;
        };
        match &object.body {
            Some(body) => moves |= body.kind == BodyKind::Dynamic,
            None => {
                let error = error_at(format!("`{}` has no `body`", name.value), &name.origin);
                cx.push(error.help("give the object `body = \"dynamic\"` or `body = \"fixed\"`"));
                return;
            }
        }
    }
    if !moves {
        let error = error_at("neither side of the joint can move".to_owned(), &joint.origin);
        cx.push(error.help("one of the bodies has to be dynamic"));
    }
}
