//! Joints between bodies.

use crate::convert::{rotation, vector};
use etendue::math::{DMat3, DQuat, DVec3};
use etendue_scene::physics::{JointKind, JointRecord, MotorRecord};
use rapier3d_f64::prelude::{GenericJoint, GenericJointBuilder, JointAxesMask, JointAxis, MotorModel, Pose, RigidBody};

/// A joint whose first body, in the engine's order, is what the record's first body moves against.
pub fn joint(record: &JointRecord, against: &RigidBody, moved: &RigidBody) -> GenericJoint {
    let (locked, free) = match record.kind {
        JointKind::Hinge => (JointAxesMask::LOCKED_REVOLUTE_AXES, Some(JointAxis::AngX)),
        JointKind::Ball => (JointAxesMask::LOCKED_SPHERICAL_AXES, None),
        JointKind::Slider => (JointAxesMask::LOCKED_PRISMATIC_AXES, Some(JointAxis::LinX)),
        JointKind::Fixed => (JointAxesMask::LOCKED_FIXED_AXES, None),
    };
    let place = Pose::from_parts(vector(record.anchor), rotation(frame(record.axis)));
    let mut joint = GenericJointBuilder::new(locked)
        .local_frame1(against.position().inverse() * place)
        .local_frame2(moved.position().inverse() * place)
        .contacts_enabled(record.collide);
    if let Some(axis) = free {
        // Degrees outside, radians in the engine.
        let unit = |x: f64| if record.kind == JointKind::Hinge { x.to_radians() } else { x };
        if let Some(limits) = record.limits {
            joint = joint.limits(axis, limits.map(unit));
        }
        if let Some(MotorRecord { velocity, position, stiffness, damping, max_force }) = record.motor {
            joint = joint.motor_model(axis, MotorModel::ForceBased);
            joint = joint.set_motor(axis, unit(position), unit(velocity), stiffness, damping);
            joint = joint.motor_max_force(axis, max_force.unwrap_or(f64::MAX));
        }
    }
    joint.build()
}

/// A rotation that takes x to `axis`.
fn frame(axis: DVec3) -> DQuat {
    let side = axis.any_orthonormal_vector();
    DQuat::from_mat3(&DMat3::from_cols(axis, side, axis.cross(side))).normalize()
}
