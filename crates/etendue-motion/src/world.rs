//! The engine's world, made of a scene.

use crate::{
    MotionError,
    convert::{rotation, vector},
    frame::Frame,
    joints, mass,
    shapes::{self, Part},
    solid::{self, Solid},
};
use etendue::math::DVec3;
use etendue_scene::{
    Input, Origin,
    description::{ObjectRecord, SceneDescription},
    physics::{BodyKind, BodyRecord, CollisionShape, Combine, Mass, PhysicsRecord},
};
use rapier3d_f64::prelude::{
    ActiveHooks, CoefficientCombineRule, ColliderBuilder, FrictionModel, Group, InteractionGroups, InteractionTestMode,
    MassProperties, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle, SpringCoefficients,
};
use std::{
    collections::BTreeMap,
    panic::{AssertUnwindSafe, catch_unwind},
    rc::Rc,
};

/// Bodies slower than this many of their sizes a second may be put to sleep.
const SLOW: f64 = 0.01;
/// Seconds that they have to be as slow for that.
const REST: f64 = 0.5;

/// A body of the world and the object that it moves.
pub struct Placed<'a> {
    /// Index into the description's objects.
    pub object: usize,
    /// The object's name.
    pub name: &'a str,
    /// How it moves.
    pub body: &'a BodyRecord,
    /// In the world.
    pub handle: RigidBodyHandle,
    /// Where it starts.
    pub frame: Frame,
}

/// The world, and its bodies in the order of the description.
pub struct Stage<'a> {
    /// All that is simulated.
    pub world: PhysicsWorld,
    /// One an object with a body.
    pub bodies: Vec<Placed<'a>>,
}

/// What a body's shape depends on: the parts' shapes, how they are stretched, and what is asked of them.
type ShapeKey = (Vec<usize>, [u64; 9], CollisionShape, bool);

/// What bodies of one shape share.
struct Made {
    parts: Vec<Part>,
    /// For 1 kg/m³.
    unit_mass: MassProperties,
    /// Largest extent, metres.
    size: f64,
}

struct Builder<'a> {
    input: &'a Input,
    groups: Groups<'a>,
    made: Vec<(ShapeKey, Rc<Made>)>,
}

/// Which groups collide, as bits.
struct Groups<'a> {
    names: BTreeMap<&'a str, u32>,
    /// Bits that a group ignores.
    ignored: BTreeMap<u32, u32>,
}

/// The world of a description whose parts `input` has. Steps are not set.
///
/// # Errors
/// [`MotionError::NoBodies`] and [`MotionError::Body`].
pub fn stage<'a>(description: &'a SceneDescription, input: &'a Input) -> Result<Stage<'a>, MotionError> {
    let mut builder = Builder { input, groups: Groups::new(description), made: Vec::new() };
    let mut world = PhysicsWorld { gravity: vector(description.physics.gravity), ..PhysicsWorld::default() };
    let mut bodies = Vec::new();
    let mut sizes = Vec::new();
    for (index, object) in description.objects.iter().enumerate() {
        let Some(body) = &object.body else { continue };
        let name = name_of(input, index, object);
        let (frame, made) = builder.shape(index, name, body)?;
        if body.kind == BodyKind::Dynamic {
            sizes.push(made.size);
        }
        let handle = insert(&mut world, &builder.groups, body, &frame, &made, &description.physics);
        bodies.push(Placed { object: index, name, body, handle, frame });
    }
    if sizes.is_empty() {
        return Err(MotionError::NoBodies);
    }
    set_parameters(&mut world, &description.physics, &mut sizes);
    join(&mut world, description, &bodies);
    Ok(Stage { world, bodies })
}

/// What an object is called.
pub fn name_of<'a>(input: &'a Input, index: usize, object: &'a ObjectRecord) -> &'a str {
    let part = || input.placed.get(index).and_then(|range| input.parts.objects.get(range.start));
    match &object.name {
        Some(name) => &name.value,
        None => part().map_or("", |part| &part.name),
    }
}

impl Builder<'_> {
    /// The shape of an object's body, shared with those that are like it.
    fn shape(&mut self, index: usize, name: &str, body: &BodyRecord) -> Result<(Frame, Rc<Made>), MotionError> {
        let wrong = |what: &str| MotionError::Body {
            name: name.to_owned(),
            what: what.to_owned(),
            origin: body.origin.clone(),
        };
        let parts = &self.input.parts;
        let objects = self.input.placed.get(index).and_then(|range| parts.objects.get(range.clone())).unwrap_or(&[]);
        let bounds = solid::bounds(parts, objects);
        let (Some(first), Some((low, high))) = (objects.first(), bounds) else { return Err(wrong("has no shape")) };
        let frame = Frame::new(&first.transform, 0.5 * (low + high));
        let is_finite = frame.rotation.is_finite() && frame.translation.is_finite() && frame.stretch.is_finite();
        if !is_finite {
            return Err(wrong("is not of this world: its transform is not finite, or flattens it"));
        }
        let pushed = body.kind == BodyKind::Dynamic;
        let shapes: Vec<usize> = objects.iter().map(|object| object.shape).collect();
        let key = (shapes, frame.stretch.to_cols_array().map(f64::to_bits), body.shape, pushed);
        if let Some((_, made)) = self.made.iter().find(|(other, _)| *other == key) {
            return Ok((frame, made.clone()));
        }
        let solids: Vec<Solid> =
            objects.iter().filter_map(|object| Solid::new(&parts.shapes[object.shape], &frame)).collect();
        let size = (frame.stretch * (high - low)).length() / 3f64.sqrt();
        let made = make(&solids, body, pushed, size).map_err(|what| wrong(&what))?;
        let made = Rc::new(made);
        self.made.push((key, made.clone()));
        Ok((frame, made))
    }
}

fn make(solids: &[Solid], body: &BodyRecord, pushed: bool, size: f64) -> Result<Made, String> {
    if !(size > 0.0 && size.is_finite()) {
        return Err("has no size".to_owned());
    }
    // Geometry from anywhere goes to algorithms that were not made for all of it.
    let parts = catch_unwind(AssertUnwindSafe(|| shapes::shape(solids, body.shape, pushed)));
    let parts = parts.unwrap_or_else(|_| Err("has a surface that no collision shape could be made of".to_owned()))?;
    let exact: Option<Vec<MassProperties>> = solids.iter().map(mass::properties).collect();
    let unit_mass = exact.map_or_else(|| mass_of(&parts), |exact| exact.into_iter().sum());
    let has_mass = |mass: &MassProperties| mass.mass() > 0.0 && mass.mass().is_finite() && mass.local_com.is_finite();
    // Triangles that bound no volume weigh what their hull does.
    let unit_mass = match has_mass(&unit_mass) || !pushed {
        true => unit_mass,
        false => mass_of(&shapes::shape(solids, CollisionShape::Hull, pushed)?),
    };
    if pushed && !has_mass(&unit_mass) {
        return Err("has no volume, and so no mass".to_owned());
    }
    Ok(Made { parts, unit_mass, size })
}

/// For 1 kg/m³.
fn mass_of(parts: &[Part]) -> MassProperties {
    parts.iter().map(|(pose, shape)| shape.mass_properties(1.0).transform_by(pose)).sum()
}

fn insert(
    world: &mut PhysicsWorld,
    groups: &Groups,
    body: &BodyRecord,
    frame: &Frame,
    made: &Made,
    physics: &PhysicsRecord,
) -> RigidBodyHandle {
    let builder = match body.kind {
        BodyKind::Dynamic => RigidBodyBuilder::dynamic(),
        BodyKind::Fixed => RigidBodyBuilder::fixed(),
        BodyKind::Kinematic => RigidBodyBuilder::kinematic_position_based(),
    };
    let builder = builder
        .pose(rapier3d_f64::math::Pose::from_parts(vector(frame.translation), rotation(frame.rotation)))
        .linvel(vector(body.linear_velocity))
        .angvel(vector(body.angular_velocity * (std::f64::consts::PI / 180.0)))
        .linear_damping(body.linear_damping)
        .angular_damping(body.angular_damping)
        .gravity_scale(body.gravity_scale)
        .gyroscopic_forces_enabled(true)
        .ccd_enabled(true)
        .soft_ccd_prediction(f64::MAX.sqrt())
        .can_sleep(physics.sleep && physics.gravity != DVec3::ZERO && body.gravity_scale != 0.0);
    let mut mass = made.unit_mass;
    match body.mass {
        Mass::Total(total) => mass.set_mass(total, true),
        Mass::Density(density) => mass.set_mass(mass.mass() * density, true),
    }
    let builder = match body.kind {
        BodyKind::Dynamic => builder.additional_mass_properties(mass),
        BodyKind::Fixed | BodyKind::Kinematic => builder,
    };
    let mut built = builder.build();
    let rest = built.activation_mut();
    if rest.normalized_linear_threshold >= 0.0 {
        rest.normalized_linear_threshold = SLOW;
        rest.time_until_sleep = REST.max(16.0 * physics.step);
    }
    let handle = world.insert_body(built);
    for (pose, shape) in &made.parts {
        let mut collider = ColliderBuilder::new(shape.clone())
            .position(*pose)
            .density(0.0)
            .friction(body.friction)
            .restitution(body.restitution)
            .friction_combine_rule(rule(physics.friction_rule))
            .restitution_combine_rule(rule(physics.restitution_rule))
            .collision_groups(groups.of(body));
        if body.restitution > 0.0 {
            collider = collider.active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS);
        }
        world.insert_collider(collider, Some(handle));
    }
    handle
}

fn rule(rule: Combine) -> CoefficientCombineRule {
    match rule {
        Combine::Average => CoefficientCombineRule::Average,
        Combine::Min => CoefficientCombineRule::Min,
        Combine::Multiply => CoefficientCombineRule::Multiply,
        Combine::Max => CoefficientCombineRule::Max,
        Combine::GeometricMean => CoefficientCombineRule::GeometricMean,
    }
}

/// The median size of the bodies that move sets the scale of tolerances.
fn set_parameters(world: &mut PhysicsWorld, physics: &PhysicsRecord, sizes: &mut [f64]) {
    sizes.sort_unstable_by(f64::total_cmp);
    let softness =
        SpringCoefficients { natural_frequency: physics.contact_frequency, damping_ratio: physics.contact_damping };
    let parameters = &mut world.integration_parameters;
    parameters.dt = physics.step;
    parameters.min_ccd_dt = physics.step / 100.0;
    parameters.length_unit = physics.length_unit.unwrap_or_else(|| sizes[sizes.len() / 2]);
    parameters.num_solver_iterations = physics.substeps as usize;
    parameters.num_internal_pgs_iterations = physics.iterations as usize;
    parameters.contact_softness = softness;
    parameters.static_contact_softness = softness;
    parameters.normalized_max_linear_velocity = f64::MAX;
    // Contacts that are kept while bodies move a little would hold back what rolls.
    parameters.contact_recycling = false;
    // Its Coulomb friction, one constraint a contact point, is 13 % too weak for a block on four corners; this one is right to 1e-4.
    parameters.friction_model = FrictionModel::Simplified;
}

fn join(world: &mut PhysicsWorld, description: &SceneDescription, bodies: &[Placed]) {
    let handles: BTreeMap<&str, RigidBodyHandle> = bodies.iter().map(|body| (body.name, body.handle)).collect();
    let mut ground = None;
    for record in &description.joints {
        let Some(&moved) = handles.get(record.bodies.0.value.as_str()) else { continue };
        let against = match &record.bodies.1 {
            Some(name) => handles.get(name.value.as_str()).copied(),
            None => Some(*ground.get_or_insert_with(|| world.insert_body(RigidBodyBuilder::fixed()))),
        };
        let Some(against) = against else { continue };
        let joint = joints::joint(record, &world.bodies[against], &world.bodies[moved]);
        world.insert_impulse_joint(against, moved, joint);
    }
}

impl<'a> Groups<'a> {
    /// The groups in the order of the description.
    fn new(description: &'a SceneDescription) -> Self {
        let mut names = BTreeMap::new();
        for body in description.objects.iter().filter_map(|object| object.body.as_ref()) {
            if let Some(group) = &body.group {
                // Bit 0 is for bodies of no group.
                let next = names.len() as u32 + 1;
                names.entry(group.value.as_str()).or_insert(next);
            }
        }
        let mut ignored = BTreeMap::new();
        for [a, b] in &description.physics.ignore {
            if let (Some(&a), Some(&b)) = (names.get(a.value.as_str()), names.get(b.value.as_str())) {
                *ignored.entry(a).or_insert(0) |= 1 << b;
                *ignored.entry(b).or_insert(0) |= 1 << a;
            }
        }
        Self { names, ignored }
    }

    fn of(&self, body: &BodyRecord) -> InteractionGroups {
        let number = body.group.as_ref().and_then(|group| self.names.get(group.value.as_str())).copied().unwrap_or(0);
        let ignored = self.ignored.get(&number).copied().unwrap_or(0);
        let (member, others) = (Group::from_bits_retain(1 << number), Group::from_bits_retain(!ignored));
        InteractionGroups::new(member, others, InteractionTestMode::And)
    }
}

/// Where a body is described.
pub fn origin(body: &Placed) -> Origin {
    body.body.origin.clone()
}
