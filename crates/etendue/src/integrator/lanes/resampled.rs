//! Light samples of lanes out of several candidates: see [`resampling`](crate::integrator::resampling).

use super::{
    group::Lanes,
    numbers::{Numbers, Vectors},
};
use crate::{
    bsdf::LANES,
    integrator::resampling::{Reservoir, magnitude},
    math::{Vec3, vec3},
    sampling::{Sampler, Slot},
};
use etendue_accel::Kernel;

/// The candidates that were kept, and what the choice needs.
pub(super) struct Kept {
    total: Numbers,
    u: Numbers,
    target: Vectors,
    has_target: [u32; LANES],
    contribution: Vectors,
    origin: Vectors,
    direction: Vectors,
}

impl Kept {
    pub const NONE: Self = Self {
        total: [0.0; LANES],
        u: [0.0; LANES],
        target: Vectors::ZERO,
        has_target: [0; LANES],
        contribution: Vectors::ZERO,
        origin: Vectors::ZERO,
        direction: Vectors::ZERO,
    };
}

/// Keeps the new candidates, or those that were kept before.
pub(super) struct Keep<'a> {
    pub lanes: &'a mut Lanes,
    pub sampler: Sampler,
    /// 0 for the first, which finds none.
    pub candidate: u32,
}

impl Kernel for Keep<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.lanes.whole();
        let Lanes { keys, lights, kept, .. } = self.lanes;
        if self.candidate == 0 {
            self.sampler.one_d_lanes(keys, n, Slot::LightResampling, &mut kept.u);
            kept.total[..n].fill(0.0);
            kept.contribution = Vectors::ZERO;
        }
        for i in 0..n {
            let contribution = lights.contribution.spectrum(i);
            let mut reservoir = Reservoir { total: kept.total[i], u: kept.u[i] };
            let is_taken = reservoir.takes(magnitude(contribution));
            (kept.total[i], kept.u[i]) = (reservoir.total, reservoir.u);
            let pick = |new: f32, old: f32| if is_taken { new } else { old };
            let pick3 = |new: Vec3, old: Vec3| vec3(pick(new.x, old.x), pick(new.y, old.y), pick(new.z, old.z));
            kept.contribution.set(i, pick3(lights.contribution.get(i), kept.contribution.get(i)));
            kept.target.set(i, pick3(lights.target.get(i), kept.target.get(i)));
            kept.origin.set(i, pick3(lights.origin.get(i), kept.origin.get(i)));
            kept.direction.set(i, pick3(lights.direction.get(i), kept.direction.get(i)));
            kept.has_target[i] = if is_taken { lights.has_target[i] } else { kept.has_target[i] };
        }
    }
}

/// The light samples are those that were kept, each for all candidates.
pub(super) struct TakeKept<'a> {
    pub lanes: &'a mut Lanes,
}

impl Kernel for TakeKept<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.lanes.whole();
        let candidates = self.lanes.candidates;
        let Lanes { lights, kept, .. } = self.lanes;
        for i in 0..n {
            let reservoir = Reservoir { total: kept.total[i], u: 0.0 };
            lights.contribution.set_spectrum(i, reservoir.whole(kept.contribution.spectrum(i), candidates));
            lights.target.set(i, kept.target.get(i));
            lights.origin.set(i, kept.origin.get(i));
            lights.direction.set(i, kept.direction.get(i));
            lights.has_target[i] = kept.has_target[i];
        }
    }
}
