//! The full surface point, made once per hit after traversal.

use crate::{
    math::{Vec2, Vec3, acos, atan2, vec2, vec3},
    parallel,
    scene::{Placement, Primitives},
    texture::{Footprint, Lookup},
};
use etendue_accel::{Hit, Place, PrimitiveId, Ray, Transform, prefetch};
use std::f32::consts::PI;

/// Where there is no light.
pub const NO_LIGHT: u32 = u32::MAX;

/// Half a unit in the last place of 1: the relative rounding error of one operation.
const EPSILON: f32 = f32::EPSILON * 0.5;

/// A point of a surface: world space relative to the scene's centre, metres.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// The point.
    pub position: Vec3,
    /// A distance along `geometric_normal` that covers the rounding error of `position`.
    pub offset: f32,
    /// Unit normal of the true surface, on its front side.
    pub geometric_normal: Vec3,
    /// Unit interpolated normal, in the hemisphere of `geometric_normal` but for rounding at silhouettes.
    pub shading_normal: Vec3,
    /// Index of the material.
    pub material: u32,
    /// Index of the light that this primitive is, or [`NO_LIGHT`].
    pub light: u32,
    /// What was hit; its instance is the object.
    pub id: PrimitiveId,
    /// When: shutter time in [0, 1].
    pub time: f32,
}

impl SurfacePoint {
    /// Origin for a ray that leaves towards `direction`: moved off the surface, to that side, by the rounding error of the
    /// position. Together with the skip id this is the one method against self-intersection, for all shapes.
    #[inline]
    pub fn leave(&self, direction: Vec3) -> Vec3 {
        leave(self.position, self.geometric_normal, self.offset, direction)
    }
}

/// See [`SurfacePoint::leave`].
#[inline(always)]
pub(crate) fn leave(position: Vec3, geometric_normal: Vec3, offset: f32, direction: Vec3) -> Vec3 {
    let side = offset.copysign(direction.dot(geometric_normal));
    position + geometric_normal * side
}

/// Makes the surface point of a hit.
#[inline]
pub(crate) fn surface_point(placement: &Placement, ray: &Ray, hit: &Hit) -> SurfacePoint {
    let local = match &placement.primitives {
        Primitives::Mesh(mesh) => mesh.point(hit),
        Primitives::Sphere { center, radius } => {
            let origin = Vec3::from(ray.origin);
            let direction = Vec3::from(ray.direction);
            let on_ray = match placement.place.at(ray.time) {
                None => origin + direction * hit.t,
                Some(t) => {
                    Vec3::from(t.point_to_object(ray.origin)) + Vec3::from(t.vector_to_object(ray.direction)) * hit.t
                }
            };
            sphere_point(*center, *radius, on_ray)
        }
    };
    let world = match &placement.place {
        Place::World => local,
        Place::Fixed(transform) => local.to_world(transform, 1.0),
        // Both maps are rounded each on its own.
        Place::Moving(motion) => local.to_world(&motion.at(ray.time), 2.0),
    };
    let primitive = hit.id.primitive;
    SurfacePoint {
        position: world.position,
        offset: world.error.dot(world.geometric_normal.abs()),
        geometric_normal: world.geometric_normal,
        shading_normal: world.shading_normal,
        material: placement.material(primitive),
        light: placement.light(hit),
        id: hit.id,
        time: ray.time,
    }
}

/// Texture coordinates about a point, and how the point moves with them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chart {
    /// Texture coordinates: the mesh's own, else barycentric weights of the second and third vertex; for spheres longitude
    /// and latitude in [0, 1], y up.
    pub uv: Vec2,
    /// Change of position, world space, metres, for a unit of u.
    pub dpdu: Vec3,
    /// The same for v.
    pub dpdv: Vec3,
}

impl Chart {
    /// Change of the texture coordinates along a vector of the surface's plane; zero where they do not tell.
    #[inline]
    pub fn coordinates_of(&self, v: Vec3) -> Vec2 {
        let (guu, guv, gvv) = (self.dpdu.dot(self.dpdu), self.dpdu.dot(self.dpdv), self.dpdv.dot(self.dpdv));
        let (u, v) = (v.dot(self.dpdu), v.dot(self.dpdv));
        let uv = vec2(gvv * u - guv * v, guu * v - guv * u) / (guu * gvv - guv * guv);
        if uv.is_finite() { uv } else { Vec2::ZERO }
    }

    /// The direction of growing u within the plane that the unit vector `normal` is perpendicular to; `None` where there is
    /// none.
    #[inline]
    pub fn tangent(&self, normal: Vec3) -> Option<Vec3> {
        (self.dpdu - normal * normal.dot(self.dpdu)).try_normalize()
    }
}

/// Texture coordinates of a hit.
#[inline]
pub(crate) fn texture_coordinates(placement: &Placement, point: &SurfacePoint, hit: &Hit) -> Vec2 {
    texture_coordinates_at(placement, hit.id.primitive, [hit.u, hit.v], point.position, point.time)
}

/// Texture coordinates at weights of a triangle's second and third vertex, or at a point of a sphere, world space, at a time.
#[inline]
pub(crate) fn texture_coordinates_at(
    placement: &Placement,
    face: u32,
    [u, v]: [f32; 2],
    position: Vec3,
    time: f32,
) -> Vec2 {
    match &placement.primitives {
        Primitives::Mesh(mesh) => {
            let [a, b, c] = mesh.corner_uvs(face).unwrap_or([Vec2::ZERO, Vec2::X, Vec2::Y]);
            a * (1.0 - u - v) + b * u + c * v
        }
        Primitives::Sphere { center, radius } => {
            let d = (on_sphere(placement, position, time) - *center) / *radius;
            let longitude = atan2(-d.z, d.x) * (0.5 / PI);
            vec2(if longitude < 0.0 { longitude + 1.0 } else { longitude }, acos(-d.y.clamp(-1.0, 1.0)) / PI)
        }
    }
}

/// A sphere's point in the sphere's own space.
#[inline]
fn on_sphere(placement: &Placement, position: Vec3, time: f32) -> Vec3 {
    match placement.place.at(time) {
        None => position,
        Some(t) => Vec3::from(t.point_to_object(position.into())),
    }
}

/// Texture coordinates of a hit with their directions.
pub(crate) fn chart(placement: &Placement, point: &SurfacePoint, hit: &Hit) -> Chart {
    let (dpdu, dpdv) = match &placement.primitives {
        Primitives::Mesh(mesh) => mesh.tangents(hit.id.primitive),
        Primitives::Sphere { center, .. } => {
            let d = on_sphere(placement, point.position, point.time) - *center;
            // u turns about y; v goes from the south pole to the north pole.
            let ring = vec2(d.x, d.z).length();
            let up = if ring > 0.0 { vec3(-d.x * d.y / ring, ring, -d.z * d.y / ring) } else { Vec3::ZERO };
            (vec3(d.z, 0.0, -d.x) * (2.0 * PI), up * PI)
        }
    };
    let transform = placement.place.at(point.time);
    let to_world = |v: Vec3| transform.as_ref().map_or(v, |t| Vec3::from(t.vector_to_world(v.into())));
    Chart { uv: texture_coordinates(placement, point, hit), dpdu: to_world(dpdu), dpdv: to_world(dpdv) }
}

/// Where textures are looked up, as a point: at weights of a triangle's second and third vertex, or at a point of a sphere,
/// world space, at a time.
pub(crate) fn lookup(placement: &Placement, face: u32, weights: [f32; 2], position: Vec3, time: f32) -> Lookup {
    let color = match &placement.primitives {
        Primitives::Mesh(mesh) => mesh.color(face, weights),
        Primitives::Sphere { .. } => [1.0; 4],
    };
    let uv = texture_coordinates_at(placement, face, weights, position, time);
    let position = placement.pose.at(time).map_or(position, |t| t.point_to_object(position.into()).into());
    let own = placement.to_own.map(|[x, y, z, w]| x * position.x + y * position.y + z * position.z + w);
    Lookup { color, ..Lookup::new(uv, Vec3::from_array(own)) }
}

/// Longest that a cone's footprint is, in its widths: beyond, the surface is seen from its edge.
const LONGEST: f32 = 64.0;

/// Where textures are looked up at a hit, over what a cone covers that is `width` wide there, metres, seen from `wo`.
pub(crate) fn lookup_over(placement: &Placement, point: &SurfacePoint, hit: &Hit, wo: Vec3, width: f32) -> Lookup {
    let at = lookup(placement, hit.id.primitive, [hit.u, hit.v], point.position, point.time);
    let pose = placement.pose.at(point.time);
    let own = |v: Vec3| {
        let v = pose.as_ref().map_or(v, |t| t.vector_to_object(v.into()).into());
        Vec3::from_array(placement.to_own.map(|[x, y, z, _]| x * v.x + y * v.y + z * v.z))
    };
    let chart = chart(placement, point, hit);
    let tangents = [own(chart.dpdu), own(chart.dpdv)];
    // An ellipse in the plane of the surface: across the cone as wide as that, along it longer the more it is inclined.
    let normal = point.geometric_normal;
    let cosine = normal.dot(wo);
    let Some(along) = (wo - normal * cosine).try_normalize().or_else(|| normal.any_orthogonal_vector().try_normalize())
    else {
        return Lookup { tangents, ..at };
    };
    let axes = [along * (width / cosine.abs().max(1.0 / LONGEST)), normal.cross(along) * width];
    let footprint = Footprint { uv: axes.map(|axis| chart.coordinates_of(axis)), position: axes.map(own) };
    Lookup { tangents, footprint, ..at }
}

/// A point in some space, before it is known what it is made of.
struct LocalPoint {
    position: Vec3,
    /// Bound of the rounding error of each coordinate.
    error: Vec3,
    geometric_normal: Vec3,
    shading_normal: Vec3,
}

impl LocalPoint {
    /// `roundings`: how often the map was rounded for those who came here.
    fn to_world(&self, transform: &Transform, roundings: f32) -> Self {
        let abs = |rows: &[[f32; 4]; 3], v: Vec3, w: f32| -> Vec3 {
            Vec3::from_array(rows.map(|r| r[0].abs() * v.x + r[1].abs() * v.y + r[2].abs() * v.z + r[3].abs() * w))
        };
        let rounding = abs(&transform.to_world, self.position.abs(), 1.0) * (4.0 * EPSILON * roundings);
        Self {
            position: transform.point_to_world(self.position.into()).into(),
            error: abs(&transform.to_world, self.error, 0.0) * (1.0 + 4.0 * EPSILON) + rounding,
            geometric_normal: Vec3::from(transform.normal_to_world(self.geometric_normal.into())).normalize(),
            shading_normal: Vec3::from(transform.normal_to_world(self.shading_normal.into())).normalize(),
        }
    }
}

/// A hit's point moved off its facet, on `side` of it, to the mean of the planes that the vertex normals stand on (Hanika,
/// "Hacking the Shadow Terminator", 2021); `None` where that is no farther than what rounding needs.
pub(crate) fn lifted(placement: &Placement, point: &SurfacePoint, hit: &Hit, side: f32) -> Option<Vec3> {
    /// How many times the offset of rays that leave; below, a ray could miss its own facet.
    const LEAST: f32 = 16.0;
    let Primitives::Mesh(mesh) = &placement.primitives else { return None };
    let normals = mesh.normals.as_ref()?;
    let corners = mesh.indices[hit.id.primitive as usize];
    let positions = corners.map(|i| Vec3::from(mesh.positions[i as usize]));
    let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
    let on_facet = positions[0] * weights[0] + positions[1] * weights[1] + positions[2] * weights[2];
    let mut offset = Vec3::ZERO;
    for k in 0..3 {
        let normal = Vec3::from(normals[corners[k] as usize]) * side;
        offset -= normal * ((on_facet - positions[k]).dot(normal).min(0.0) * weights[k]);
    }
    let transform = placement.place.at(point.time);
    let offset = transform.map_or(offset, |t| Vec3::from(t.vector_to_world(offset.into())));
    let height = offset.dot(point.geometric_normal) * side;
    (height > LEAST * point.offset).then(|| point.position + offset)
}

fn sphere_point(center: Vec3, radius: f32, on_ray: Vec3) -> LocalPoint {
    let normal = (on_ray - center).try_normalize().unwrap_or(Vec3::Z);
    LocalPoint {
        position: center + normal * radius,
        error: (center.abs() + Vec3::splat(radius)) * (4.0 * EPSILON),
        geometric_normal: normal,
        shading_normal: normal,
    }
}

/// A mesh as surfaces need it.
#[derive(Debug)]
pub(crate) struct MeshData {
    pub positions: std::sync::Arc<[[f32; 3]]>,
    pub indices: std::sync::Arc<[[u32; 3]]>,
    pub normals: Option<std::sync::Arc<[[f32; 3]]>>,
    pub uvs: Option<std::sync::Arc<[[f32; 2]]>>,
    pub colors: Option<std::sync::Arc<[[f32; 4]]>>,
}

impl MeshData {
    /// Position of a vertex.
    #[inline]
    pub fn corner(&self, index: u32) -> Vec3 {
        Vec3::from(self.positions[index as usize])
    }

    /// Bytes that surface points are made from.
    pub fn bytes(&self) -> usize {
        let normals = self.normals.as_deref().map_or(0, size_of_val);
        size_of_val(&*self.indices) + size_of_val(&*self.positions) + normals
    }

    /// Asks for a face's corners, which are read from memory soon.
    #[inline]
    pub fn prefetch_corners(&self, face: u32) {
        for index in self.indices[face as usize] {
            prefetch(&self.positions[index as usize]);
            if let Some(normals) = &self.normals {
                prefetch(&normals[index as usize]);
            }
        }
    }

    /// True if it has no vertex normals, and no face is so small or large that f32 is too short for its normal.
    pub fn is_flat(&self) -> bool {
        let is_moderate = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|index| self.corner(index));
            is_moderate((b - a).cross(c - a))
        };
        self.normals.is_none() && !parallel::any(&self.indices, |face| !is_moderate(face))
    }

    /// Texture coordinates of a face's corners.
    #[inline]
    pub fn corner_uvs(&self, face: u32) -> Option<[Vec2; 3]> {
        let uvs = self.uvs.as_ref()?;
        Some(self.indices[face as usize].map(|i| Vec2::from(uvs[i as usize])))
    }

    /// Colour at weights of a face's second and third corner; white where there are none.
    #[inline]
    fn color(&self, face: u32, [u, v]: [f32; 2]) -> [f32; 4] {
        let Some(colors) = &self.colors else { return [1.0; 4] };
        let [a, b, c] = self.indices[face as usize].map(|i| colors[i as usize]);
        [0, 1, 2, 3].map(|i| a[i] * (1.0 - u - v) + b[i] * u + c[i] * v)
    }

    /// Change of position with texture coordinates on a face; zero where they do not tell.
    fn tangents(&self, face: u32) -> (Vec3, Vec3) {
        let [a, b, c] = self.indices[face as usize].map(|i| Vec3::from(self.positions[i as usize]));
        let [ta, tb, tc] = self.corner_uvs(face).unwrap_or([Vec2::ZERO, Vec2::X, Vec2::Y]);
        let ((e1, e2), (d1, d2)) = ((b - a, c - a), (tb - ta, tc - ta));
        let determinant = d1.x * d2.y - d1.y * d2.x;
        let (dpdu, dpdv) = ((e1 * d2.y - e2 * d1.y) / determinant, (e2 * d1.x - e1 * d2.x) / determinant);
        if dpdu.is_finite() && dpdv.is_finite() { (dpdu, dpdv) } else { (Vec3::ZERO, Vec3::ZERO) }
    }

    #[inline]
    fn point(&self, hit: &Hit) -> LocalPoint {
        let corners = self.indices[hit.id.primitive as usize];
        let [a, b, c] = corners.map(|i| Vec3::from(self.positions[i as usize]));
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let (position, error) = on_facet([a, b, c], weights);
        let geometric = face_normal(a, b, c);
        let (geometric_normal, shading_normal) = match &self.normals {
            None => (geometric, geometric),
            Some(normals) => {
                let [na, nb, nc] = corners.map(|i| Vec3::from(normals[i as usize]));
                let geometric = orient(geometric, na + nb + nc);
                let shading = na * weights[0] + nb * weights[1] + nc * weights[2];
                (geometric, shading.try_normalize().unwrap_or(geometric))
            }
        };
        LocalPoint { position, error, geometric_normal, shading_normal }
    }
}

/// A point of a facet at the weights of its corners, and a bound of the rounding error of each coordinate.
#[inline(always)]
fn on_facet([a, b, c]: [Vec3; 3], weights: [f32; 3]) -> (Vec3, Vec3) {
    let position = a * weights[0] + b * weights[1] + c * weights[2];
    // Three products, two sums and weights that add up to one but for rounding: below 12 roundings of the terms.
    let terms = a.abs() * weights[0].abs() + b.abs() * weights[1] + c.abs() * weights[2];
    (position, terms * (12.0 * EPSILON))
}

/// Position, offset and normal of the point of a flat facet of moderate size, in world space, as [`surface_point`] gives
/// them; `u` and `v` are the weights of the second and third corner. Without branches.
#[inline(always)]
pub(crate) fn flat_point([a, b, c]: [Vec3; 3], u: f32, v: f32) -> (Vec3, f32, Vec3) {
    let (position, error) = on_facet([a, b, c], [1.0 - u - v, u, v]);
    let cross = (b - a).cross(c - a);
    let normal = cross * (1.0 / cross.length_squared().sqrt());
    (position, error.dot(normal.abs()), normal)
}

/// True for triangles whose normal needs no more than f32.
#[inline]
pub(crate) fn is_moderate(cross: Vec3) -> bool {
    let squared = cross.length_squared();
    squared > 1e-30 && squared < 1e30
}

/// Unit normal of a triangle by its winding, also of very small ones.
#[inline]
pub(crate) fn face_normal(a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    let cross = (b - a).cross(c - a);
    if is_moderate(cross) {
        return cross * (1.0 / cross.length_squared().sqrt());
    }
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    (b - a).cross(c - a).try_normalize().map_or(Vec3::Z, |n| n.as_vec3())
}

/// The front side of a face is where its vertex normals point to, whatever the winding.
#[inline]
pub(crate) fn orient(geometric: Vec3, vertex_normals: Vec3) -> Vec3 {
    if geometric.dot(vertex_normals) < 0.0 { -geometric } else { geometric }
}
