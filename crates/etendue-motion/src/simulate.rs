//! A scene through time.

use crate::{
    Bake, BakedBody, MotionError,
    bounce::Bounce,
    convert::{from_rotation, from_vector, rotation, vector},
    hash,
    world::{self, Placed, Stage},
};
use etendue::{
    math::{DQuat, DVec3},
    motion::Pose,
};
use etendue_scene::{
    Input,
    description::SceneDescription,
    physics::{BodyKind, PhysicsRecord},
};
use rapier3d_f64::prelude::{PhysicsWorld, RigidBody};
use std::ops::ControlFlow;

/// Poses that one simulation may record, of all bodies together: 1.8 GB.
pub const MAX_POSES: usize = 1 << 25;
/// Bodies farther from the origin than this have flown apart, metres.
const FARTHEST: f64 = 1e12;
/// Seconds that are simulated where nothing says how many.
pub const DURATION: f64 = 10.0;

/// How far a simulation is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Steps done, those of the warm-up too.
    pub done: usize,
    /// Steps in all.
    pub total: usize,
}

/// What the caller of a simulation wants of it.
pub struct Control<'a> {
    /// Called after every step; `Break` ends in [`MotionError::Stopped`].
    pub progress: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
    /// The pose of an object, by its index, at a scene time: where its keys put it. `None` for those without keys, which rest.
    pub kinematic: &'a dyn Fn(usize, f64) -> Option<Pose>,
}

/// What the caller changes of a scene's `[physics]`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// Seconds that are recorded.
    pub duration: Option<f64>,
    /// Seconds from one recorded pose to the next.
    pub step: Option<f64>,
}

/// Simulates the bodies of a scene, from where the description puts them. `input` is what was built of `description`.
///
/// The result depends on these alone: it is the same, bit for bit, on every machine and in every run.
///
/// # Errors
/// See [`MotionError`].
pub fn simulate(
    description: &SceneDescription,
    input: &Input,
    options: Options,
    control: &mut Control,
) -> Result<Bake, MotionError> {
    let (physics, steps) = settled(&description.physics, options);
    let description = &SceneDescription { physics, ..description.clone() };
    let physics = &description.physics;
    let dynamic = description.objects.iter().filter_map(|object| object.body.as_ref());
    let bodies = dynamic.filter(|body| body.kind == BodyKind::Dynamic).count();
    if bodies.saturating_mul(steps.saturating_add(1)) > MAX_POSES {
        return Err(MotionError::TooLarge { bodies, steps, limit: MAX_POSES });
    }
    let mut stage = world::stage(description, input)?;
    let hash = hash::settings(description, physics, input, steps, control.kinematic);
    Run::new(&mut stage, physics, steps).record(control, hash)
}

/// What holds with a caller's options, and the steps that are recorded.
pub(crate) fn settled(physics: &PhysicsRecord, options: Options) -> (PhysicsRecord, usize) {
    let (step, duration) = (options.step.unwrap_or(physics.step), options.duration.or(physics.duration));
    (PhysicsRecord { step, duration, ..physics.clone() }, count(duration.unwrap_or(DURATION), step))
}

/// Steps that cover a duration; one that ends at a step to rounding has no more.
fn count(duration: f64, step: f64) -> usize {
    (duration / step - 1e-6).ceil().max(0.0) as usize
}

struct Run<'a, 'b> {
    stage: &'b mut Stage<'a>,
    physics: &'b PhysicsRecord,
    bounce: Bounce,
    warm_up: usize,
    steps: usize,
}

impl<'a, 'b> Run<'a, 'b> {
    fn new(stage: &'b mut Stage<'a>, physics: &'b PhysicsRecord, steps: usize) -> Self {
        let part = physics.step / f64::from(physics.substeps);
        let bounce = Bounce { gravity: physics.gravity, step: physics.step, part };
        for (_, body) in stage.world.bodies.iter_mut() {
            if body.is_dynamic() {
                // Leapfrog: the engine's velocities are those in the middle of a part.
                let shift = vector(physics.gravity * (body.gravity_scale() * -0.5 * part));
                let velocity = body.linvel() + shift;
                body.set_linvel(velocity, true);
            }
        }
        Self { stage, physics, bounce, warm_up: count(physics.warm_up, physics.step), steps }
    }

    fn record(&mut self, control: &mut Control, hash: [u8; 32]) -> Result<Bake, MotionError> {
        let total = self.warm_up + self.steps;
        let dynamic = self.stage.bodies.iter().enumerate().filter(|(_, body)| body.body.kind == BodyKind::Dynamic);
        let recorded: Vec<usize> = dynamic.map(|(index, _)| index).collect();
        let centers: Vec<DVec3> = recorded.iter().map(|&index| self.center(index)).collect();
        let mut poses: Vec<Vec<Pose>> = recorded.iter().map(|_| Vec::with_capacity(self.steps + 1)).collect();
        for done in 0..=total {
            if done >= self.warm_up {
                for (poses, &index) in poses.iter_mut().zip(&recorded) {
                    let body = &self.stage.bodies[index];
                    poses.push(pose(body, &self.stage.world.bodies[body.handle]));
                }
            }
            if done == total {
                break;
            }
            self.step(control, done)?;
            if (control.progress)(Progress { done: done + 1, total }).is_break() {
                return Err(MotionError::Stopped);
            }
        }
        let times = (0..=self.steps).map(|k| self.physics.start + k as f64 * self.physics.step).collect();
        let baked = |((poses, &index), center): ((Vec<Pose>, &usize), DVec3)| {
            let body = &self.stage.bodies[index];
            BakedBody { object: body.object, name: body.name.to_owned(), center, poses: poses.into() }
        };
        let step = self.physics.step;
        Ok(Bake { times, step, bodies: poses.into_iter().zip(&recorded).zip(centers).map(baked).collect(), hash })
    }

    /// A body's centre of mass before anything moves.
    fn center(&self, index: usize) -> DVec3 {
        let Placed { frame, handle, .. } = &self.stage.bodies[index];
        let local = from_vector(self.stage.world.bodies[*handle].mass_properties().local_mprops.local_com);
        frame.rotation * local + frame.translation
    }

    /// One step, after `done` of them.
    fn step(&mut self, control: &Control, done: usize) -> Result<(), MotionError> {
        let after = (done + 1) as f64 - self.warm_up as f64;
        let time = self.physics.start + after.max(0.0) * self.physics.step;
        for placed in &self.stage.bodies {
            if placed.body.kind == BodyKind::Kinematic
                && let Some(pose) = (control.kinematic)(placed.object, time)
                && let Some(body) = self.stage.world.bodies.get_mut(placed.handle)
            {
                body.set_next_kinematic_position(moved(placed, pose));
            }
        }
        self.stage.world.step_with_events(&self.bounce, &());
        match exploded(&self.stage.world, &self.stage.bodies) {
            Some(body) => Err(MotionError::Exploded {
                name: body.name.to_owned(),
                time: (done + 1) as f64 * self.physics.step,
                origin: world::origin(body),
            }),
            None => Ok(()),
        }
    }
}

/// A body that is no longer anywhere.
fn exploded<'a, 'b>(world: &PhysicsWorld, bodies: &'b [Placed<'a>]) -> Option<&'b Placed<'a>> {
    let lost = world.quarantine();
    bodies.iter().find(|placed| {
        let Some(body) = world.bodies.get(placed.handle) else { return true };
        let at = body.translation();
        let colliders = || body.colliders().iter().any(|collider| lost.colliders().contains(collider));
        !(at.abs().max_element() < FARTHEST && body.rotation().is_finite())
            || (!lost.is_empty() && (lost.bodies().contains(&placed.handle) || colliders()))
    })
}

/// What has happened to a body since the start.
fn pose(placed: &Placed, body: &RigidBody) -> Pose {
    let start = &placed.frame;
    let (now, at) = (from_rotation(*body.rotation()), from_vector(body.translation()));
    let rotation = match now == start.rotation {
        true => DQuat::IDENTITY,
        false => (now * start.rotation.conjugate()).normalize(),
    };
    let shifted = match rotation == DQuat::IDENTITY {
        true => at - start.translation,
        false => at - rotation * start.translation,
    };
    Pose { rotation, translation: shifted + DVec3::ZERO }
}

/// Where a pose puts a body.
fn moved(placed: &Placed, pose: Pose) -> rapier3d_f64::math::Pose {
    let start = &placed.frame;
    let at = pose.rotation * start.translation + pose.translation;
    rapier3d_f64::math::Pose::from_parts(vector(at), rotation((pose.rotation * start.rotation).normalize()))
}
