//! Lights on things that move while the shutter is open.
//!
//! Rigid motion changes no solid angle and no area. So a light is listed where it is in the middle of the exposure, and at
//! another time what gathers is taken there instead: the point and its normal by the motion from that time to the middle;
//! the direction or point that is drawn comes back by its inverse, with the same density. The choice of a light goes by how
//! all of its way looks, in about. What light samples may miss there BSDF samples find, with the weight that they need.

use super::{LightContext, LightSample, extent::Extent};
use crate::math::{DAffine3, DMat3, DVec3, Vec3};
use etendue_accel::Motion;
use std::{ops::Range, sync::Arc};

/// The time at which carried lights are listed.
pub(crate) const LISTED_AT: f32 = 0.5;

/// Times at which the way of a light is looked at.
const LOOKS: u8 = 9;

/// What moves some lights.
#[derive(Clone, Debug)]
pub(crate) struct Carrier {
    /// Their indices.
    lights: Range<u32>,
    /// From the world (relative to the scene's centre) without motion to where it is; rigid.
    motion: Arc<Motion>,
    middle: DAffine3,
}

impl Carrier {
    /// `motion` must be rigid.
    pub fn new(lights: Range<u32>, motion: Arc<Motion>) -> Self {
        let middle = affine(&motion, LISTED_AT);
        Self { lights, motion, middle }
    }

    /// From a time to the middle of the exposure.
    fn to_middle(&self, time: f32) -> DAffine3 {
        self.middle * affine(&self.motion, time).inverse()
    }

    /// The same view of the lights at the middle of the exposure, and the way there.
    pub fn seen_at_middle(&self, ctx: &LightContext) -> (LightContext, Way) {
        let way = Way(self.to_middle(ctx.time));
        let normal = if ctx.normal == Vec3::ZERO { Vec3::ZERO } else { way.vector(ctx.normal) };
        (LightContext { point: way.point(ctx.point), normal, ..*ctx }, way)
    }

    /// The extent of one of the lights on all of its way, in about.
    pub(super) fn widened(&self, extent: &Extent) -> Extent {
        let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|corner| {
            let side = |bit: u8, low: f32, high: f32| f64::from(if corner >> bit & 1 == 0 { low } else { high });
            let (low, high) = (extent.low, extent.high);
            DVec3::new(side(0, low.x, high.x), side(1, low.y, high.y), side(2, low.z, high.z))
        });
        let mut wide = *extent;
        for look in 0..LOOKS {
            let way = self.to_middle(f32::from(look) / f32::from(LOOKS - 1)).inverse();
            for corner in corners {
                let at = way.transform_point3(corner).as_vec3();
                (wide.low, wide.high) = (wide.low.min(at), wide.high.max(at));
            }
            let cosine = way.transform_vector3(extent.axis.as_dvec3()).as_vec3().dot(extent.axis);
            let turned = libm::acosf(cosine.clamp(-1.0, 1.0));
            wide.spread = wide.spread.max(extent.spread + turned).min(std::f32::consts::PI);
        }
        wide
    }
}

fn affine(motion: &Motion, time: f32) -> DAffine3 {
    let rows = motion.rows_at(time);
    let column = |c: usize| DVec3::new(rows[0][c], rows[1][c], rows[2][c]);
    DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

/// A rigid map.
pub(crate) struct Way(DAffine3);

impl Way {
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.0.transform_point3(p.as_dvec3()).as_vec3()
    }

    /// Of unit length.
    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.0.transform_vector3(v.as_dvec3()).normalize().as_vec3()
    }

    /// A sample taken there, back here.
    pub fn back(&self, sample: LightSample) -> LightSample {
        let Self(there) = self;
        let back = there.matrix3.transpose();
        let wi = (back * sample.wi.as_dvec3()).normalize().as_vec3();
        let target = sample.target.map(|target| (back * (target.as_dvec3() - there.translation)).as_vec3());
        LightSample { wi, target, ..sample }
    }
}

/// All that moves lights, by the first light.
#[derive(Clone, Debug, Default)]
pub(crate) struct Carriers(Vec<Carrier>);

impl Carriers {
    /// By ascending lights.
    pub fn new(carriers: Vec<Carrier>) -> Self {
        Self(carriers)
    }

    /// What moves light `index`.
    #[inline]
    pub fn of(&self, index: u32) -> Option<&Carrier> {
        if self.0.is_empty() {
            return None;
        }
        let after = self.0.partition_point(|carrier| carrier.lights.start <= index);
        self.0[..after].last().filter(|carrier| carrier.lights.contains(&index))
    }
}
