//! Speeds after collisions, corrected for gravity within the step.
//!
//! The engine reflects the velocity that a body has at the beginning of a step, and moves bodies by semi-implicit Euler. So a ball that
//! bounces would lose what gravity adds on the rest of its way down, in every bounce. Bodies start with half of a part's gravity
//! taken off their velocity (leapfrog), which puts free flight on its parabola to rounding; here the restitution of each new
//! contact is replaced by one that gives the right speed after the impact.

use crate::convert::from_vector;
use etendue::math::DVec3;
use rapier3d_f64::{
    geometry::{ContactManifold, NEW_CONTACT_BIT, SolverContact},
    pipeline::ContactModificationContext,
    prelude::{PhysicsHooks, RigidBody},
};

/// Corrects restitution.
pub struct Bounce {
    /// m/s².
    pub gravity: DVec3,
    /// Length of a step, s.
    pub step: f64,
    /// Length of a part of it, s.
    pub part: f64,
}

/// How two bodies approach at a point.
struct Approach {
    /// Speed, m/s.
    speed: f64,
    /// Distance, metres; not below 0.
    distance: f64,
}

impl Bounce {
    /// Of free flight; what is not dynamic falls nowhere.
    fn acceleration(&self, body: Option<&RigidBody>) -> DVec3 {
        body.filter(|body| body.is_dynamic()).map_or(DVec3::ZERO, |body| self.gravity * body.gravity_scale())
    }

    /// The restitution to be applied to `approach`, for which the bodies accelerate towards each other by `closing`.
    fn corrected(&self, restitution: f64, approach: &Approach, closing: f64) -> f64 {
        let shift = 0.5 * closing * self.part;
        let speed = approach.speed + shift;
        let impact = (speed * speed + 2.0 * closing * approach.distance).max(0.0).sqrt();
        if restitution < 1.0 && impact <= closing * self.step {
            return 0.0;
        }
        // The engine turns bodies round where they would meet in the first part of the next step. Then they have the speed that they
        // would have there on their way back.
        let flight = self.step * (approach.speed + 0.5 * closing * (self.step + self.part));
        let left = (approach.distance - flight).max(0.0);
        let after = restitution * impact;
        let after = (after * after - 2.0 * closing * left).max(0.0).sqrt();
        ((after + shift) / approach.speed).max(0.0)
    }
}

/// A contact that bore no load in the last step.
fn is_new(contact: &SolverContact, manifold: &ContactManifold) -> bool {
    let index = (contact.contact_id[0] & !NEW_CONTACT_BIT) as usize;
    manifold.points.get(index).is_none_or(|point| point.data.impulse == 0.0)
}

impl PhysicsHooks for Bounce {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext) {
        let body = |handle| context.bodies.get(handle);
        let (first, second) = (context.rigid_body1.and_then(body), context.rigid_body2.and_then(body));
        let closing_acceleration = self.acceleration(first) - self.acceleration(second);
        let velocity =
            |body: Option<&RigidBody>, at| body.map_or(DVec3::ZERO, |body| from_vector(body.velocity_at_point(at)));
        let Some(rigid) = context.rigid() else { return };
        if *rigid.restitution <= 0.0 {
            return;
        }
        let normal = from_vector(*rigid.normal);
        let approach = |contact: &SolverContact| Approach {
            speed: (velocity(first, contact.anchor1) - velocity(second, contact.anchor2)).dot(normal),
            distance: contact.dist.max(0.0),
        };
        let fresh = rigid.solver_contacts.iter().filter(|contact| is_new(contact, rigid.manifold));
        let approaching = fresh.map(approach).filter(|approach| approach.speed > 0.0);
        // The point that hits first decides for all of the manifold.
        let soonest = approaching.min_by(|a, b| (a.distance * b.speed).total_cmp(&(b.distance * a.speed)));
        let Some(approach) = soonest else { return };
        let corrected = self.corrected(*rigid.restitution, &approach, closing_acceleration.dot(normal));
        if let Some(rigid) = context.rigid_mut() {
            *rigid.restitution = corrected;
        }
    }
}
