//! Vertices in lanes: those whose BSDF has a form for it, from all over a wave and sorted by kind, go through light samples and
//! scattering together, in loops that become vector code.
//!
//! Which vertices these are depends on scene and vertex alone, and a lane's numbers on nothing in other lanes, so results
//! depend neither on the size of waves nor on the instruction set. The formulas are those of [`shade`](super::shade), and
//! give the same bits: they share the functions that are more than a product.

mod group;
mod lights;
mod numbers;
mod rectangles;
mod resampled;
mod stages;

use super::{
    paths::Paths,
    resampling::{CANDIDATES, is_resampled},
    shade::Strategy,
    shadow::ShadowQueue,
    splitting,
    wave::Context,
};
use crate::{
    bsdf::{Diffuse, Glass, InLanes, Lambert, LaneBsdf, Mirror, Mtl, PhongInLanes, RoughGlass, RoughMetal},
    math::Vec3,
};
use etendue_accel::PrimitiveId;
use group::Lanes;
use std::marker::PhantomData;

/// A vertex for lanes: all but how it scatters.
pub(super) struct SurfaceVertex {
    /// Where light is gathered on the side of `wo`, and rays on that side leave from; with how far they are moved off, 0 for a point
    /// that was lifted, and what they do not meet.
    pub position: Vec3,
    pub offset: f32,
    pub skip: PrimitiveId,
    /// The same for rays to the other side.
    pub beyond: Vec3,
    pub beyond_offset: f32,
    pub beyond_skip: PrimitiveId,
    pub geometric_normal: Vec3,
    pub shading_normal: Vec3,
    /// See [`Horizon`](super::horizon::Horizon).
    pub base: Vec3,
    pub roughness: f32,
    /// Unit, towards where the path comes from.
    pub wo: Vec3,
}

/// The vertices of a wave that scatter in the same way and draw light samples alike: on plain facets, and all others.
struct Sort<B> {
    facets: Box<Lanes>,
    vertices: Box<Lanes>,
    kind: PhantomData<B>,
}

impl<B: LaneBsdf> Sort<B> {
    fn new(candidates: u32) -> Self {
        let lanes = |flat| Lanes::new(flat, B::TRANSMITS).with_candidates(candidates);
        Self { facets: lanes(true), vertices: lanes(false), kind: PhantomData }
    }

    fn finish(&mut self, context: &Context, strategy: Strategy, paths: &mut Paths, shadows: &mut ShadowQueue) {
        self.facets.finish::<B>(context, strategy, paths, shadows);
        self.vertices.finish::<B>(context, strategy, paths, shadows);
    }
}

/// The vertices of a wave that scatter in the same way.
struct Group<B> {
    plain: Sort<B>,
    /// Those whose light samples are out of several candidates.
    resampled: Sort<B>,
}

impl<B: LaneBsdf> Group<B> {
    fn new() -> Self {
        Self { plain: Sort::new(1), resampled: Sort::new(CANDIDATES) }
    }

    /// Where path `path` goes at its vertex.
    #[inline]
    fn sort(&mut self, context: &Context, paths: &Paths, path: usize) -> &mut Sort<B> {
        let is_resampled = !B::IS_DELTA && is_resampled(context, paths, path, B::TRANSMITS);
        if is_resampled { &mut self.resampled } else { &mut self.plain }
    }

    fn finish(&mut self, context: &Context, strategy: Strategy, paths: &mut Paths, shadows: &mut ShadowQueue) {
        self.plain.finish(context, strategy, paths, shadows);
        self.resampled.finish(context, strategy, paths, shadows);
    }
}

/// As [`splitting::each_part`], for a BSDF that may have nothing but single directions.
#[inline]
fn each_part<B: LaneBsdf>(context: &Context, paths: &mut Paths, path: usize, mut push: impl FnMut(&mut Paths, usize)) {
    if B::IS_DELTA { push(paths, path) } else { splitting::each_part(context, paths, path, push) }
}

macro_rules! groups {
    ($($group:ident: $Kind:ident($Bsdf:ty)),* $(,)?) => {
        /// The vertices of a wave that are in lanes, by how they scatter.
        pub(super) struct Groups {
            $($group: Group<$Bsdf>),*
        }

        impl Groups {
            pub fn new() -> Self {
                Self { $($group: Group::new()),* }
            }

            /// Takes over path `path`, which has hit something with these corners, if that is a plain facet.
            #[inline]
            pub fn take_facet(
                &mut self,
                context: &Context,
                strategy: Strategy,
                paths: &mut Paths,
                (path, corners): (usize, &[Vec3; 3]),
                shadows: &mut ShadowQueue,
            ) -> bool {
                let mut textured = None;
                let Some(bsdf) = context.scene.plain_facet(&paths.hits[path], corners, &mut textured) else {
                    return false;
                };
                let progress = &mut paths.progress[path];
                if progress.depth >= context.max_depth {
                    progress.alive = false;
                    return true;
                }
                paths.cones[path] = paths.cones[path].advanced(paths.hits[path].t);
                match *bsdf {
                    $(InLanes::$Kind(bsdf) => {
                        let lanes = &mut self.$group.sort(context, paths, path).facets;
                        each_part::<$Bsdf>(context, paths, path, |paths, path| {
                            lanes.push_facet(paths, path, corners, bsdf);
                            if lanes.is_full() {
                                lanes.finish::<$Bsdf>(context, strategy, paths, shadows);
                            }
                        });
                    })*
                }
                true
            }

            /// Takes over path `path` at the vertex that it has reached.
            #[inline]
            pub fn take(
                &mut self,
                context: &Context,
                strategy: Strategy,
                paths: &mut Paths,
                path: usize,
                (vertex, bsdf): &(SurfaceVertex, InLanes),
                shadows: &mut ShadowQueue,
            ) {
                match *bsdf {
                    $(InLanes::$Kind(bsdf) => {
                        let lanes = &mut self.$group.sort(context, paths, path).vertices;
                        each_part::<$Bsdf>(context, paths, path, |paths, path| {
                            lanes.push(paths, path, vertex, bsdf);
                            if lanes.is_full() {
                                lanes.finish::<$Bsdf>(context, strategy, paths, shadows);
                            }
                        });
                    })*
                }
            }

            /// Takes all paths on that were taken over.
            pub fn finish(&mut self, context: &Context, strategy: Strategy, paths: &mut Paths, shadows: &mut ShadowQueue) {
                $(self.$group.finish(context, strategy, paths, shadows);)*
            }
        }
    };
}

groups! {
    lambert: Lambert(Lambert),
    diffuse: Diffuse(Diffuse),
    mirror: Mirror(Mirror),
    glass: Glass(Glass),
    rough_metal: RoughMetal(RoughMetal),
    rough_glass: RoughGlass(RoughGlass),
    mtl: Mtl(Mtl),
    phong: Phong(PhongInLanes<false>),
    phong_both_sides: PhongBothSides(PhongInLanes<true>),
}
