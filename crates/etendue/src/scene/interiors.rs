//! What bodies hold, and which of the bodies that a point lies in counts.
//!
//! A path keeps a stack of the bodies that it has entered. Where bodies overlap, the one with the highest priority is there
//! (Schmidt and Budge, "Simple Nested Dielectrics in Ray Traced Images", 2002), among equals the one entered last; surfaces
//! of the others are passed straight through.

use super::{SceneError, SceneParts};
use crate::{
    material::{Material, Scattering},
    math::{DVec3, Vec3},
    medium::Medium,
    spectrum::Spectrum,
    surface::SurfacePoint,
};

/// Bodies that a point can lie in at once; more are not told apart.
pub const MAX_NESTED: usize = 8;

/// No medium, and no body.
const NONE: u32 = u32::MAX;

/// Bodies of one instance that are alike are one body.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Kind {
    /// Index into the media, or [`NONE`].
    medium: u32,
    priority: i32,
}

/// The body that a material bounds.
#[derive(Clone, Copy, Debug)]
struct Boundary {
    kind: u32,
    /// Index of refraction behind the surface: the body's own with a priority, else over that before it.
    index: f32,
    /// True if `index` is the body's own.
    absolute: bool,
    /// False if the surface is always there, however the priorities: what emits is found by light samples too.
    can_hide: bool,
    /// True for smooth clear glass: among bodies of the same index there is no surface.
    clear: bool,
}

/// A body that a path is in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Entered {
    instance: u32,
    kind: u32,
    /// Index of refraction.
    index: f32,
}

/// The bodies that a point lies in, in the order in which they were entered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyStack {
    entered: [Entered; MAX_NESTED],
    depth: u32,
    /// The medium at the point.
    medium: u32,
    /// True once there were more than [`MAX_NESTED`].
    pub overflowed: bool,
}

/// What a surface is to a path that meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meeting {
    /// There is no surface: a body with a higher priority is on both sides, or it is clear and the index is the same on both.
    pub hidden: bool,
    /// Index of refraction outside of the body, where the body's is its own; else 1.
    pub surroundings: f32,
}

impl Meeting {
    /// A surface like any other.
    pub const PLAIN: Self = Self { hidden: false, surroundings: 1.0 };
}

/// The media of a scene and where they are.
#[derive(Debug)]
pub(crate) struct Interiors {
    media: Vec<Medium>,
    kinds: Vec<Kind>,
    /// By material.
    boundaries: Vec<Option<Boundary>>,
    /// Outside of all bodies.
    world: u32,
    has_bodies: bool,
    may_hide: bool,
}

impl Interiors {
    /// Resolves the names of media; `center` is what all positions will be relative to.
    ///
    /// # Errors
    /// When a material or the world names a medium that is not among `parts.media`.
    pub fn new(parts: &SceneParts, center: DVec3) -> Result<Self, SceneError> {
        let find = |name: &str, user: &dyn Fn() -> String| -> Result<u32, SceneError> {
            let found = parts.media.iter().position(|medium| medium.name == name);
            let index = found.ok_or_else(|| SceneError::Medium { user: user(), name: name.to_owned() })?;
            Ok(if parts.media[index].is_vacuum() { NONE } else { index as u32 })
        };
        let mut kinds: Vec<Kind> = Vec::new();
        let mut boundaries = Vec::with_capacity(parts.materials.len());
        for material in &parts.materials {
            let Material { interior, priority, .. } = material;
            if interior.is_none() && priority.is_none() {
                boundaries.push(None);
                continue;
            }
            let user = || format!("material `{}`", material.name);
            let medium = interior.as_ref().map_or(Ok(NONE), |name| find(name, &user))?;
            let kind = Kind { medium, priority: priority.unwrap_or(0) };
            let at = kinds.iter().position(|k| *k == kind).unwrap_or(kinds.len());
            if at == kinds.len() {
                kinds.push(kind);
            }
            boundaries.push(Some(Boundary {
                kind: at as u32,
                index: material.scattering.ior().map_or(1.0, |ior| ior.factor),
                absolute: priority.is_some(),
                can_hide: material.emission.is_none(),
                clear: is_clear(material),
            }));
        }
        let world = parts.world_medium.as_ref().map_or(Ok(NONE), |name| find(name, &|| "the world".to_owned()))?;
        let has_bodies = boundaries.iter().any(Option::is_some);
        let hides = |b: &Boundary| b.absolute || (b.clear && b.index == 1.0);
        let may_hide = boundaries.iter().flatten().any(hides);
        let media = parts.media.iter().map(|medium| medium.relative_to(center)).collect();
        Ok(Self { media, kinds, boundaries, world, has_bodies, may_hide })
    }

    /// True if paths must keep track of where they are.
    pub fn matter(&self) -> bool {
        self.has_bodies || self.world != NONE
    }

    /// True if some surfaces bound bodies.
    pub fn has_bodies(&self) -> bool {
        self.has_bodies
    }

    /// True if some surfaces may be no surfaces where a path meets them.
    pub fn may_hide(&self) -> bool {
        self.may_hide
    }

    /// True if what fills the world lets no light from infinity through.
    pub fn hides_infinity(&self) -> bool {
        self.media.get(self.world as usize).is_some_and(Medium::hides_infinity)
    }

    /// Outside of all bodies.
    pub fn outside(&self) -> BodyStack {
        BodyStack { entered: [Entered::default(); MAX_NESTED], depth: 0, medium: self.world, overflowed: false }
    }

    /// Leaves every body.
    #[inline]
    pub fn leave_all(&self, stack: &mut BodyStack) {
        *stack = BodyStack { overflowed: stack.overflowed, ..self.outside() };
    }

    /// The medium where a stack is; `None` where nothing is.
    #[inline]
    pub fn medium(&self, stack: &BodyStack) -> Option<&Medium> {
        self.media.get(stack.medium as usize)
    }

    /// A number for the body that a material of an instance bounds; `None` if it bounds none.
    pub fn body(&self, instance: u32, material: u32) -> Option<(u32, u32)> {
        self.boundaries[material as usize].map(|boundary| (instance, boundary.kind))
    }

    /// What a surface is to a path with this stack that travels in `direction`.
    #[inline]
    pub fn meet(&self, stack: &BodyStack, point: &SurfacePoint, direction: Vec3) -> Meeting {
        let Some(boundary) = self.boundaries[point.material as usize] else { return Meeting::PLAIN };
        let body = if is_entering(point, direction) { None } else { stack.find(point.id.instance, boundary.kind) };
        let others = self.winner(stack, body);
        let surroundings = if boundary.absolute { self.index(stack, body, i32::MAX) } else { 1.0 };
        let beaten = others.is_some_and(|other| {
            let (own, its) = (self.kinds[boundary.kind as usize].priority, self.priority(stack, other));
            its > own || (its == own && body.is_some_and(|body| other > body))
        });
        let hidden = boundary.can_hide && (beaten || (boundary.clear && boundary.index == surroundings));
        Meeting { hidden, surroundings }
    }

    /// Follows a path that goes through a surface in `direction`.
    #[inline]
    pub fn cross(&self, stack: &mut BodyStack, point: &SurfacePoint, direction: Vec3) {
        let Some(boundary) = self.boundaries[point.material as usize] else { return };
        if is_entering(point, direction) {
            self.enter(stack, point.id.instance, point.material);
        } else if let Some(at) = stack.find(point.id.instance, boundary.kind) {
            stack.entered.copy_within(at + 1.., at);
            stack.depth -= 1;
            self.update(stack);
        }
    }

    /// Enters the body that a material of an instance bounds.
    pub fn enter(&self, stack: &mut BodyStack, instance: u32, material: u32) {
        let Some(boundary) = self.boundaries[material as usize] else { return };
        if stack.depth as usize == MAX_NESTED {
            stack.overflowed = true;
            return;
        }
        // What the body is in must not depend on where its surface is hidden.
        let priority = self.kinds[boundary.kind as usize].priority;
        let outside = if boundary.absolute { 1.0 } else { self.index(stack, None, priority) };
        let index = boundary.index * outside;
        stack.entered[stack.depth as usize] = Entered { instance, kind: boundary.kind, index };
        stack.depth += 1;
        self.update(stack);
    }

    fn update(&self, stack: &mut BodyStack) {
        let winner = self.winner(stack, None);
        stack.medium = winner.map_or(self.world, |at| self.kinds[stack.entered[at].kind as usize].medium);
    }

    fn priority(&self, stack: &BodyStack, at: usize) -> i32 {
        self.kinds[stack.entered[at].kind as usize].priority
    }

    /// Index of refraction where a stack is, one body being left out and those above a priority.
    #[inline]
    fn index(&self, stack: &BodyStack, without: Option<usize>, highest: i32) -> f32 {
        let counts = |at: &usize| Some(*at) != without && self.priority(stack, *at) <= highest;
        let winner = (0..stack.depth as usize).filter(counts).max_by_key(|at| self.priority(stack, *at));
        winner.map_or(1.0, |at| stack.entered[at].index)
    }

    /// Which of the bodies counts, one being left out.
    #[inline]
    fn winner(&self, stack: &BodyStack, without: Option<usize>) -> Option<usize> {
        // The last of equal maxima: the one entered last.
        (0..stack.depth as usize).filter(|at| Some(*at) != without).max_by_key(|at| self.priority(stack, *at))
    }
}

impl BodyStack {
    /// Where a body was entered last.
    #[inline]
    fn find(&self, instance: u32, kind: u32) -> Option<usize> {
        let entered = &self.entered[..self.depth as usize];
        entered.iter().rposition(|e| e.instance == instance && e.kind == kind)
    }
}

/// True for a surface that does nothing where the index of refraction is the same on both sides.
fn is_clear(material: &Material) -> bool {
    let clear = Some(Spectrum::ONE);
    let tint = material.scattering.constant().and_then(|values| match values {
        Scattering::Glass { transmission_tint, thin: false, .. } => Some(transmission_tint),
        _ => None,
    });
    tint == clear && material.relief.is_none()
}

/// True if `direction` goes against the surface's normal.
#[inline]
pub(crate) fn is_entering(point: &SurfacePoint, direction: Vec3) -> bool {
    direction.dot(point.geometric_normal) < 0.0
}
