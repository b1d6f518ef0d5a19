//! Light samples on rectangles: of those that are far, which are most, and then of the others by the map of solid angle, which costs
//! three times as much.
#![expect(clippy::needless_range_loop, reason = "an index is the lane, in several arrays at once")]

use super::{
    group::Lanes,
    lights::{Kind, LightSamples, Lit},
    numbers::{Numbers, Vectors},
};
use crate::{
    bsdf::LANES,
    integrator::wave::Context,
    light::{LightContext, RectangleFrame},
};
use etendue_accel::{Kernel, run};

/// Lanes to which rectangles are near, side by side.
pub(super) struct Near {
    len: usize,
    /// Which lanes.
    lane: [u32; LANES],
    point: Vectors,
    normal: Vectors,
    place: [Numbers; 2],
    /// Corner and edges, where each lane has its own.
    shape: [Vectors; 3],
    two_sided: [u32; LANES],
    samples: LightSamples,
}

impl Near {
    pub const NONE: Self = Self {
        len: 0,
        lane: [0; LANES],
        point: Vectors::ZERO,
        normal: Vectors::ZERO,
        place: [[0.0; LANES]; 2],
        shape: [Vectors::ZERO; 3],
        two_sided: [0; LANES],
        samples: LightSamples::NONE,
    };
}

impl Lanes {
    /// Samples of rectangles; lanes for which neither way is good enough still ask.
    pub fn sample_rectangles(&mut self, context: &Context) {
        let isa = context.scene.accelerator().isa();
        match self.shared_rectangle(context) {
            // A copy, so that nothing in the loops can be thought to change it.
            Some(frame) => run(isa, Rectangles { lanes: self, frames: Shared(*frame) }),
            None => run(isa, Rectangles { lanes: self, frames: Own }),
        }
    }

    /// The rectangle that all lanes with rectangles have chosen, if it is one.
    fn shared_rectangle<'a>(&self, context: &Context<'a>) -> Option<&'a RectangleFrame> {
        let mut chosen = (0..self.len).filter(|i| self.shaped_lights.kind[*i] == Kind::Rectangle as u32);
        let first = self.lights.index[chosen.next()?];
        let is_shared = chosen.all(|i| self.lights.index[i] == first);
        context.scene.uniform_rectangle(first).filter(|_| is_shared)
    }
}

/// Whose rectangles.
trait Frames {
    const OWN: bool;

    fn get(&self, shape: &[Vectors; 3], two_sided: &[u32; LANES], i: usize) -> RectangleFrame;
}

/// One for all lanes that chose one.
struct Shared(RectangleFrame);

/// Each lane's own.
struct Own;

impl Frames for Shared {
    const OWN: bool = false;

    #[inline(always)]
    fn get(&self, _shape: &[Vectors; 3], _two_sided: &[u32; LANES], _i: usize) -> RectangleFrame {
        self.0
    }
}

impl Frames for Own {
    const OWN: bool = true;

    #[inline(always)]
    fn get(&self, shape: &[Vectors; 3], two_sided: &[u32; LANES], i: usize) -> RectangleFrame {
        RectangleFrame::new([shape[0].get(i), shape[1].get(i), shape[2].get(i)], two_sided[i] != 0)
    }
}

struct Rectangles<'a, F> {
    lanes: &'a mut Lanes,
    frames: F,
}

impl<F: Frames> Kernel for Rectangles<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        // Told apart outside of the loops.
        let Self { lanes, frames } = self;
        if lanes.transmits {
            sample_far::<F, false>(lanes, &frames);
            list_near::<F>(lanes);
            sample_near::<F, false>(lanes, &frames);
        } else {
            sample_far::<F, true>(lanes, &frames);
            list_near::<F>(lanes);
            sample_near::<F, true>(lanes, &frames);
        }
    }
}

/// Samples of all rectangles as if they were far, kept where they are.
#[inline(always)]
fn sample_far<F: Frames, const ONE_SIDED: bool>(lanes: &mut Lanes, frames: &F) {
    let n = lanes.whole();
    let Lanes { lights, shaped_lights: shaped, vertices, drawn, .. } = lanes;
    for i in 0..n {
        let frame = frames.get(&shaped.shape, &shaped.two_sided, i);
        let view = frame.view::<ONE_SIDED>(&vertices.light_context(i, !ONE_SIDED));
        let point = view.sample_patch([drawn.place[0][i], drawn.place[1][i]]);
        let seen = if view.is_patch { Lit::Continuous } else { Lit::Ask };
        let found = if view.is_seen { seen } else { Lit::No };
        lights.take(i, shaped.kind[i] == Kind::Rectangle as u32, found, &point, true);
    }
}

/// Puts the lanes that are left side by side.
#[inline(always)]
fn list_near<F: Frames>(lanes: &mut Lanes) {
    let (n, transmits) = (lanes.len, lanes.transmits);
    let Lanes { lights, shaped_lights: shaped, vertices, drawn, near, .. } = lanes;
    near.len = 0;
    for i in 0..n {
        if (shaped.kind[i] == Kind::Rectangle as u32) & (lights.lit[i] == Lit::Ask as u32) {
            let (to, context) = (near.len, vertices.light_context(i, transmits));
            near.lane[to] = i as u32;
            near.point.set(to, context.point);
            near.normal.set(to, context.normal);
            near.place[0][to] = drawn.place[0][i];
            near.place[1][to] = drawn.place[1][i];
            near.samples.probability[to] = lights.probability[i];
            if F::OWN {
                for (to_row, row) in near.shape.iter_mut().zip(&shaped.shape) {
                    to_row.set(to, row.get(i));
                }
                near.two_sided[to] = shaped.two_sided[i];
            }
            near.len += 1;
        }
    }
}

/// Samples by the map of those that were listed.
#[inline(always)]
fn sample_near<F: Frames, const ONE_SIDED: bool>(lanes: &mut Lanes, frames: &F) {
    let Lanes { lights, near, .. } = lanes;
    if near.len == 0 {
        return;
    }
    // Whole vectors: those beyond the last are idle.
    let n = near.len.next_multiple_of(8).min(LANES);
    let Near { samples, point, normal, place, shape, two_sided, .. } = near;
    for k in 0..n {
        let context = LightContext { point: point.get(k), normal: normal.get(k), transmits: !ONE_SIDED, time: 0.0 };
        let frame = frames.get(shape, two_sided, k);
        let view = frame.view::<ONE_SIDED>(&context);
        let map = frame.map(&view);
        let point = frame.sample_map(&view, &map, [place[0][k], place[1][k]]);
        let found = if map.is_accurate { Lit::Continuous } else { Lit::Ask };
        samples.take(k, true, found, &point, true);
    }
    for k in 0..near.len {
        let i = near.lane[k] as usize;
        lights.lit[i] = near.samples.lit[k];
        lights.wi.set(i, near.samples.wi.get(k));
        lights.target.set(i, near.samples.target.get(k));
        lights.density[i] = near.samples.density[k];
    }
}
