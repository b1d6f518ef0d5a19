//! What tells whether a recorded motion is still that of a scene.

use crate::{Options, simulate::settled, world::name_of};
use etendue::{math::DVec3, motion::Pose, scene::Shape};
use etendue_scene::{
    Input,
    description::SceneDescription,
    physics::{BodyKind, BodyRecord, JointRecord, Mass, PhysicsRecord},
};
use sha2::{Digest, Sha256};

/// Grows with every change of what the numbers mean.
const VERSION: u64 = 2;

struct Hash(Sha256);

impl Hash {
    fn numbers(&mut self, numbers: &[f64]) {
        self.0.update((numbers.len() as u64).to_le_bytes());
        numbers.iter().for_each(|x| self.0.update(x.to_bits().to_le_bytes()));
    }

    fn vector(&mut self, v: DVec3) {
        self.numbers(&v.to_array());
    }

    fn optional(&mut self, x: Option<f64>) {
        self.numbers(x.as_slice());
    }

    fn whole(&mut self, x: u64) {
        self.0.update(x.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.whole(text.len() as u64);
        self.0.update(text.as_bytes());
    }
}

/// SHA-256 of all that the poses of a simulation depend on: physics, bodies with their names, geometry and kinematic motion, joints, number of
/// steps; of nothing else in the scene. [`simulate`](crate::simulate) with the same arguments gives this hash to its poses, without whose cost it
/// tells whether poses that were recorded before are still those of a scene. `kinematic` is [`Control::kinematic`](crate::Control::kinematic).
pub fn motion_hash(
    description: &SceneDescription,
    input: &Input,
    options: Options,
    kinematic: &dyn Fn(usize, f64) -> Option<Pose>,
) -> [u8; 32] {
    let (physics, steps) = settled(&description.physics, options);
    settings(description, &physics, input, steps, kinematic)
}

/// As [`motion_hash`], with the options in `physics` and `steps`.
pub fn settings(
    description: &SceneDescription,
    physics: &PhysicsRecord,
    input: &Input,
    steps: usize,
    kinematic: &dyn Fn(usize, f64) -> Option<Pose>,
) -> [u8; 32] {
    let mut hash = Hash(Sha256::new());
    hash.whole(VERSION);
    hash.whole(steps as u64);
    physics_record(&mut hash, physics);
    let bodies =
        description.objects.iter().enumerate().filter_map(|(i, object)| Some((i, object, object.body.as_ref()?)));
    hash.whole(bodies.clone().count() as u64);
    for (index, object, body) in bodies {
        hash.text(name_of(input, index, object));
        record(&mut hash, body);
        geometry(&mut hash, index, input);
        if body.kind == BodyKind::Kinematic {
            let PhysicsRecord { start, step, .. } = *physics;
            for pose in (0..=steps).filter_map(|k| kinematic(index, start + k as f64 * step)) {
                hash.vector(pose.translation);
                hash.numbers(&pose.rotation.to_array());
            }
        }
    }
    for joint in &description.joints {
        joint_record(&mut hash, joint);
    }
    hash.0.finalize().into()
}

fn physics_record(hash: &mut Hash, physics: &PhysicsRecord) {
    let PhysicsRecord { gravity, step, start, warm_up, contact_frequency, contact_damping, .. } = physics;
    hash.vector(*gravity);
    hash.numbers(&[*step, *start, *warm_up, *contact_frequency, *contact_damping]);
    hash.optional(physics.length_unit);
    for number in [physics.substeps, physics.iterations, physics.sleep.into()] {
        hash.whole(number.into());
    }
    for rule in [physics.friction_rule, physics.restitution_rule] {
        hash.text(rule.name());
    }
    hash.whole(physics.ignore.len() as u64);
    for group in physics.ignore.iter().flatten() {
        hash.text(&group.value);
    }
}

fn record(hash: &mut Hash, body: &BodyRecord) {
    for text in [body.kind.name(), body.shape.name(), body.group.as_ref().map_or("", |group| &group.value)] {
        hash.text(text);
    }
    let mass = match body.mass {
        Mass::Total(mass) => [0.0, mass],
        Mass::Density(density) => [1.0, density],
    };
    hash.numbers(&mass);
    hash.numbers(&[body.friction, body.restitution, body.linear_damping, body.angular_damping, body.gravity_scale]);
    hash.vector(body.linear_velocity);
    hash.vector(body.angular_velocity);
}

fn geometry(hash: &mut Hash, index: usize, input: &Input) {
    let objects = input.placed.get(index).and_then(|range| input.parts.objects.get(range.clone())).unwrap_or(&[]);
    hash.whole(objects.len() as u64);
    for object in objects {
        hash.numbers(&object.transform.to_cols_array());
        match &input.parts.shapes[object.shape] {
            Shape::Sphere { center, radius } => {
                hash.vector(*center);
                hash.numbers(&[*radius]);
            }
            Shape::Rectangle { corner, u, v } => [*corner, *u, *v].into_iter().for_each(|p| hash.vector(p)),
            Shape::Mesh(mesh) => {
                hash.vector(mesh.origin);
                [mesh.positions.len(), mesh.indices.len()].iter().for_each(|&count| hash.whole(count as u64));
                mesh.positions.iter().flatten().for_each(|x| hash.0.update(x.to_bits().to_le_bytes()));
                mesh.indices.iter().flatten().for_each(|i| hash.0.update(i.to_le_bytes()));
            }
        }
    }
}

fn joint_record(hash: &mut Hash, joint: &JointRecord) {
    hash.text(joint.kind.name());
    hash.text(&joint.bodies.0.value);
    hash.text(joint.bodies.1.as_ref().map_or("", |name| &name.value));
    hash.vector(joint.anchor);
    hash.vector(joint.axis);
    hash.numbers(joint.limits.as_ref().map_or(&[], |limits| limits));
    if let Some(motor) = joint.motor {
        hash.numbers(&[motor.velocity, motor.position, motor.stiffness, motor.damping]);
        hash.optional(motor.max_force);
    }
    hash.whole(joint.collide.into());
}
