//! Emissive disks.

use super::{
    Arcs, Emitter, LightCircle, LightContext, LightSample, Reached,
    elliptic_cone::EllipticCone,
    finite_density,
    planar::{DrawnPoint, Facing},
    projected_cone::ProjectedCone,
    round_outline::RoundOutline,
};
use crate::{
    math::{DVec3, Vec3},
    spectrum::Spectrum,
};
use std::f64::consts::PI;

/// An emissive flat polygon that is nearly a disk, sampled as the disk about it: by projected solid angle where light is gathered on
/// one side of a surface (`ProjectedCone`), else by solid angle to within a factor of two (`EllipticCone`). Points between the
/// polygon and the circle count as no sample.
#[derive(Clone, Debug, PartialEq)]
pub struct DiskLight {
    /// Where it is; its front is where its normal points.
    pub outline: RoundOutline,
    /// W sr^-1 m^-2.
    pub radiance: Spectrum,
    /// Emits from the back too.
    pub two_sided: bool,
}

/// The light as seen from a context on an emitting side.
struct View<'a> {
    outline: &'a RoundOutline,
    facing: Facing,
    /// The disk's middle, relative to the context.
    center: DVec3,
    cone: EllipticCone,
}

impl<'a> View<'a> {
    /// `None` where nothing of the light is seen.
    fn new(light: &'a DiskLight, ctx: &LightContext) -> Option<Self> {
        let outline = &light.outline;
        let (middle, radius) = (outline.center(), outline.radius());
        let bounds = [middle, middle - DVec3::splat(radius), middle + DVec3::splat(radius)];
        let facing = Facing::new(ctx, &bounds, outline.normal(), light.two_sided)?;
        let center = middle - ctx.point.as_dvec3();
        let cone = EllipticCone::of_disk(center, facing.normal(), facing.height(), radius);
        Some(Self { outline, facing, center, cone })
    }

    /// What is above the horizon, where its cosines count.
    fn projected(&self, ctx: &LightContext) -> Option<ProjectedCone<'_>> {
        let normal = ctx.normal.as_dvec3();
        let length = normal.length();
        if ctx.transmits || length == 0.0 { None } else { ProjectedCone::new(&self.cone, normal / length) }
    }

    /// From the context to where the polygon is in this direction, which is unit length and in the cone; `None` beside it.
    fn offset(&self, direction: DVec3) -> Option<DVec3> {
        let (normal, height) = (self.facing.normal(), self.facing.height());
        // The cone of a disk that is all around ends in its plane.
        let offset = direction * (height / (-direction.dot(normal)).max(1e-12));
        let from_middle = offset - self.center;
        let on = from_middle - normal * from_middle.dot(normal);
        let on = on * (self.outline.radius() / on.length()).min(1.0);
        self.outline.contains(on).then_some(self.center + on)
    }
}

impl Emitter for DiskLight {
    fn radiance(&self) -> Spectrum {
        self.radiance
    }

    fn etendue(&self, _scene_radius: f64) -> f64 {
        PI * self.outline.area() * if self.two_sided { 2.0 } else { 1.0 }
    }

    fn sample(&self, ctx: &LightContext, u: [f32; 2]) -> Option<LightSample> {
        let view = View::new(self, ctx)?;
        let projected = view.projected(ctx);
        let u = u.map(f64::from);
        let direction = projected.as_ref().map_or_else(|| view.cone.sample(u), |projected| projected.sample(u));
        let offset = view.offset(direction)?;
        // The density is that of the direction as it is rounded.
        let wi = (offset / offset.length()).as_vec3().as_dvec3();
        let density = projected.map_or_else(|| view.cone.density(wi), |projected| projected.density(wi));
        DrawnPoint::new(offset, view.facing.target(offset), [0.0; 2], density).sample(self.radiance)
    }

    fn pdf(&self, ctx: &LightContext, wi: Vec3, _distance: f32) -> f32 {
        let Some(view) = View::new(self, ctx) else { return 0.0 };
        let wi = wi.as_dvec3();
        let density = view.projected(ctx).map_or_else(|| view.cone.density(wi), |projected| projected.density(wi));
        finite_density(density).unwrap_or(0.0)
    }

    fn arcs(&self, circle: &LightCircle) -> Arcs {
        View::new(self, &circle.context()).map_or_else(Arcs::default, |view| circle.arcs_of_elliptic_cone(&view.cone))
    }

    fn reach(&self, circle: &LightCircle, phi: f64) -> Option<Reached> {
        let view = View::new(self, &circle.context())?;
        let offset = view.offset(circle.direction(phi))?;
        offset.is_finite().then(|| Reached { target: view.facing.target(offset), at: [0.0; 2] })
    }
}
