//! The surfaces that emit, as lights. Triangles that are a parallelogram or a disk together are one light. A face whose emission has a
//! texture is cut into similar pieces, each a light with the mean radiance of its box in the texture; what a sample carries is the
//! radiance at its point.

use super::{
    FaceLights, Object, Placement, Primitives, SceneParts, Shape,
    emission_map::EmissionMap,
    panels::{self, Form, Panel, PanelFace},
};
use crate::{
    light::{Carrier, DiskLight, LISTED_AT, Light, LightSample, RectangleLight, SphereLight, TriangleLight},
    material::{Emission, Material},
    math::{DVec3, Vec2, Vec3},
    spectrum::Spectrum,
    surface::{MeshData, NO_LIGHT, face_normal, lookup, orient, texture_coordinates_at},
    texture::Lookup,
};
use etendue_accel::{Place, Transform};
use std::sync::Arc;

/// Most pieces of a face along one of its sides.
const MAX_SIDE: u32 = 256;
/// Pieces that all faces together are cut into; every face has at least one.
const MAX_PIECES: f64 = (1 << 18) as f64;

/// How a face is cut into pieces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cut {
    /// A triangle into n x n similar ones, in rows along the first edge.
    Triangle(u32),
    /// A rectangle into columns and rows.
    Rectangle([u32; 2]),
    /// A sphere stays whole.
    Sphere,
}

impl Cut {
    fn count(self) -> u32 {
        match self {
            Self::Triangle(n) => n * n,
            Self::Rectangle([columns, rows]) => columns * rows,
            Self::Sphere => 1,
        }
    }

    /// The piece that a point is in: weights of a triangle's second and third vertex, or multiples of a rectangle's edges.
    #[inline]
    pub fn piece_of(self, [u, v]: [f32; 2]) -> u32 {
        // Casts saturate: whatever the numbers, the piece exists.
        let step = |x: f32, n: u32| ((x * n as f32) as u32).min(n - 1);
        match self {
            Self::Sphere => 0,
            Self::Rectangle([columns, rows]) => step(v, rows) * columns + step(u, columns),
            Self::Triangle(n) => {
                let row = step(v, n);
                let column = step(u, n).min(n - 1 - row);
                let (fu, fv) = (u * n as f32 - column as f32, v * n as f32 - row as f32);
                let upper = u32::from(fu + fv > 1.0 && column + row < n - 1);
                row * (2 * n - row) + 2 * column + upper
            }
        }
    }

    /// The corner of a piece and its edges: a point of it is the corner plus multiples of the edges.
    fn frame(self, piece: u32) -> [Vec2; 3] {
        match self {
            Self::Sphere => [Vec2::ZERO, Vec2::X, Vec2::Y],
            Self::Rectangle([columns, rows]) => {
                let (width, height) = (1.0 / columns as f32, 1.0 / rows as f32);
                let corner = Vec2::new((piece % columns) as f32 * width, (piece / columns) as f32 * height);
                [corner, Vec2::new(width, 0.0), Vec2::new(0.0, height)]
            }
            Self::Triangle(n) => {
                // Rows begin at row (2 n - row).
                let mut row = 0;
                while row + 1 < n && (row + 1) * (2 * n - (row + 1)) <= piece {
                    row += 1;
                }
                let in_row = piece - row * (2 * n - row);
                let size = 1.0 / n as f32;
                let corner = Vec2::new((in_row / 2) as f32, row as f32) * size;
                if in_row.is_multiple_of(2) {
                    [corner, Vec2::new(size, 0.0), Vec2::new(0.0, size)]
                } else {
                    [corner + Vec2::splat(size), Vec2::new(-size, 0.0), Vec2::new(0.0, -size)]
                }
            }
        }
    }

    /// Where on the face a point of a piece is.
    fn point(self, piece: u32, [a, b]: [f32; 2]) -> [f32; 2] {
        let [corner, u, v] = self.frame(piece);
        (corner + u * a + v * b).to_array()
    }

    /// Fewer pieces, by the factor `scale` along each side.
    fn coarser(self, scale: f64) -> Self {
        let fewer = |n: u32| ((f64::from(n) * scale) as u32).max(1);
        match self {
            Self::Triangle(n) => Self::Triangle(fewer(n)),
            Self::Rectangle(sides) => Self::Rectangle(sides.map(fewer)),
            Self::Sphere => Self::Sphere,
        }
    }
}

/// A face whose light varies over it.
#[derive(Clone, Copy, Debug)]
struct Varied {
    /// The light of its first piece.
    first: u32,
    placement: u32,
    face: u32,
    cut: Cut,
    /// The lights' second and third vertex, or their edges, are swapped.
    swap: bool,
}

/// The lights that vary, in ascending order.
#[derive(Debug, Default)]
pub(crate) struct VariedLights(Vec<Varied>);

impl VariedLights {
    /// The face that light `index` is a piece of.
    #[inline]
    fn find(&self, index: u32) -> Option<&Varied> {
        let after = self.0.partition_point(|varied| varied.first <= index);
        let varied = &self.0[after.checked_sub(1)?];
        (index - varied.first < varied.cut.count()).then_some(varied)
    }

    /// True if light `index` varies.
    #[inline]
    pub fn contains(&self, index: u32) -> bool {
        self.find(index).is_some()
    }

    /// Gives a sample of light `index` at a time the radiance at its point.
    #[inline]
    pub fn look_up(
        &self,
        placements: &[Placement],
        materials: &[Material],
        (index, time): (u32, f32),
        sample: LightSample,
    ) -> LightSample {
        let Some(varied) = self.find(index) else { return sample };
        let piece = index - varied.first;
        let placement = &placements[varied.placement as usize];
        let [a, b] = sample.at;
        let at = varied.cut.point(piece, if varied.swap { [b, a] } else { [a, b] });
        let position = sample.target.unwrap_or_default();
        let found = match varied.cut {
            // A rectangle's own coordinates are its texture coordinates.
            Cut::Rectangle(_) => {
                Lookup { uv: Vec2::from(at), ..lookup(placement, varied.face, [0.0; 2], position, time) }
            }
            _ => lookup(placement, varied.face, at, position, time),
        };
        LightSample { radiance: materials[placement.material(varied.face) as usize].glow(&found), ..sample }
    }
}

/// Lists the lights of all placements, in their order, and tells each placement which lights its faces are.
pub(super) fn list(parts: &SceneParts, placements: &mut [Placement]) -> Listed {
    let map = |material: &Material| material.emission.as_ref().and_then(|e| EmissionMap::new(&e.radiance));
    let maps: Vec<Option<EmissionMap>> = parts.materials.iter().map(map).collect();
    let mut lister = Lister { parts, maps, scale: 1.0, lights: Vec::new(), varied: Vec::new() };
    let pieces: f64 = placements.iter().zip(&parts.objects).map(|(p, object)| lister.pieces(p, object)).sum();
    lister.scale = (MAX_PIECES / pieces.max(1.0)).sqrt().min(1.0);
    let mut carriers = Vec::new();
    for (index, (placement, object)) in placements.iter_mut().zip(&parts.objects).enumerate() {
        let first = lister.lights.len() as u32;
        placement.lights = lister.list(index as u32, placement, object);
        let end = lister.lights.len() as u32;
        if let Place::Moving(motion) = &placement.pose
            && end > first
        {
            carriers.push(Carrier::new(first..end, motion.clone()));
        }
    }
    Listed { lights: lister.lights, varied: VariedLights(lister.varied), carriers }
}

/// The lights of all placements, those that move as they are in the middle of the exposure.
pub(super) struct Listed {
    pub lights: Vec<Light>,
    pub varied: VariedLights,
    pub carriers: Vec<Carrier>,
}

struct Lister<'a> {
    parts: &'a SceneParts,
    /// Of materials whose emission has a texture.
    maps: Vec<Option<EmissionMap>>,
    /// By how much faces are cut more coarsely than their texels would have it, at most 1.
    scale: f64,
    lights: Vec<Light>,
    varied: Vec<Varied>,
}

/// What a face emits.
struct Glow<'a> {
    /// Of an emission with a texture its factor only, times what a texture without map may be.
    radiance: Spectrum,
    map: Option<&'a EmissionMap>,
    /// Share of the map's radiance that the opacity lets be, at most.
    opacity: f32,
    is_varied: bool,
    two_sided: bool,
}

impl Lister<'_> {
    /// `None` for faces that do not emit.
    fn glow(&self, placement: &Placement, face: u32) -> Option<Glow<'_>> {
        let index = placement.material(face) as usize;
        let material = &self.parts.materials[index];
        let Emission { radiance, two_sided } = material.emission.as_ref()?;
        let opacity = material.opacity.range()[1].clamp(0.0, 1.0);
        let map = self.maps[index].as_ref();
        let is_varied = radiance.texture.is_some() || material.opacity.texture.is_some();
        // What is computed has no map: every face counts alike, by the middle of what it may be.
        let middle = |[low, high]: [f32; 2]| (0.5 * (low.max(0.0) + high.max(0.0))).min(f32::MAX);
        let likely = match &radiance.texture {
            Some(texture) if map.is_none() => middle(texture.range()),
            _ => 1.0,
        };
        let radiance = radiance.factor * (opacity * likely);
        (!radiance.is_black()).then_some(Glow { radiance, map, opacity, is_varied, two_sided: *two_sided })
    }

    /// How a triangle or rectangle is cut at full resolution; `None` if its part of the texture is black.
    fn full_cut(placement: &Placement, face: u32, glow: &Glow, is_rectangle: bool) -> Option<Cut> {
        let whole = if is_rectangle { Cut::Rectangle([1; 2]) } else { Cut::Triangle(1) };
        let Some(map) = glow.map else { return Some(whole) };
        let corners = corner_uvs(placement, face, whole, 0);
        if map.mean(&corners) <= 0.0 {
            return None;
        }
        let [a, b, c] = [corners[0], corners[1], corners[2]];
        let side = |length: f64| (length.ceil() as u32).clamp(1, MAX_SIDE);
        Some(match whole {
            Cut::Rectangle(_) => Cut::Rectangle([side(map.length(a, b)), side(map.length(a, c))]),
            _ => Cut::Triangle(side(map.length(a, b).max(map.length(a, c)).max(map.length(b, c)))),
        })
    }

    /// Pieces of a placement at full resolution.
    fn pieces(&self, placement: &Placement, object: &Object) -> f64 {
        let faces = match (&placement.primitives, self.is_rectangle(object)) {
            (Primitives::Sphere { .. }, _) => return 0.0,
            (_, true) => 1,
            (Primitives::Mesh(mesh), false) if self.emits(placement) => mesh.indices.len() as u32,
            _ => 0,
        };
        let is_rectangle = self.is_rectangle(object);
        let cuts = (0..faces).filter_map(|face| {
            let glow = self.glow(placement, face).filter(|glow| glow.map.is_some())?;
            Self::full_cut(placement, face, &glow, is_rectangle)
        });
        cuts.map(|cut| f64::from(cut.count())).sum()
    }

    fn is_rectangle(&self, object: &Object) -> bool {
        matches!(self.parts.shapes[object.shape], Shape::Rectangle { .. })
    }

    fn emits(&self, placement: &Placement) -> bool {
        placement.materials.iter().any(|m| self.parts.materials[*m as usize].emission.is_some())
    }

    fn list(&mut self, index: u32, placement: &Placement, object: &Object) -> FaceLights {
        match &placement.primitives {
            _ if !self.emits(placement) => FaceLights::None,
            Primitives::Sphere { center, radius } => self.list_sphere(index, placement, *center, *radius),
            Primitives::Mesh(mesh) if self.is_rectangle(object) => self.list_rectangle(index, placement, mesh),
            Primitives::Mesh(mesh) => self.list_triangles(index, placement, mesh),
        }
    }

    /// Radiance of a piece for the choice of lights: its mean where it varies.
    fn mean(&self, placement: &Placement, face: u32, glow: &Glow, cut: Cut, piece: u32) -> Spectrum {
        match glow.map {
            None => glow.radiance,
            Some(map) => {
                let mean = map.mean(&corner_uvs(placement, face, cut, piece)) * f64::from(glow.opacity);
                Spectrum::splat(mean.min(f64::from(f32::MAX)) as f32)
            }
        }
    }

    /// Adds the record of a face that varies, whose lights come next.
    fn vary(&mut self, is_varied: bool, placement: u32, face: u32, cut: Cut, swap: bool) {
        if is_varied {
            let first = self.lights.len() as u32;
            self.varied.push(Varied { first, placement, face, cut, swap });
        }
    }

    fn list_sphere(&mut self, index: u32, placement: &Placement, center: Vec3, radius: f32) -> FaceLights {
        let Some(glow) = self.glow(placement, 0) else { return FaceLights::None };
        // Over the whole of the texture.
        let corners = [Vec2::ZERO, Vec2::ONE];
        let radiance = match glow.map {
            None => glow.radiance,
            Some(map) => Spectrum::splat((map.mean(&corners) * f64::from(glow.opacity)) as f32),
        };
        let (two_sided, is_varied) = (glow.two_sided, glow.is_varied);
        let first = self.lights.len() as u32;
        self.vary(is_varied, index, 0, Cut::Sphere, false);
        self.lights.push(Light::Sphere(sphere_light(placement, center, radius, radiance, two_sided)));
        FaceLights::One(first)
    }

    fn list_rectangle(&mut self, index: u32, placement: &Placement, mesh: &MeshData) -> FaceLights {
        let Some(glow) = self.glow(placement, 0) else { return FaceLights::None };
        let Some(cut) = Self::full_cut(placement, 0, &glow, true) else { return FaceLights::None };
        let cut = cut.coarser(self.scale);
        let transform = placement.place.at(LISTED_AT);
        let corner =
            |i: usize| Vec3::from(transform.map_or(mesh.positions[i], |t| t.point_to_world(mesh.positions[i])));
        let [a, b, _, d] = [0, 1, 2, 3].map(corner);
        // Mirrored placements turn the winding round, and with it the front.
        let swap = mesh.indices[0] != [0, 1, 2];
        let (is_varied, two_sided, first) = (glow.is_varied, glow.two_sided, self.lights.len() as u32);
        let pieces = (0..cut.count()).map(|piece| {
            let [corner, u, v] = cut.frame(piece);
            let [u, v] = [(b - a) * u.x, (d - a) * v.y];
            let (u, v) = if swap { (v, u) } else { (u, v) };
            let corner = (a.as_dvec3() + along(b - a, corner.x) + along(d - a, corner.y)).as_vec3();
            let radiance = self.mean(placement, 0, &glow, cut, piece);
            Light::Rectangle(RectangleLight { corner, u, v, radiance, two_sided })
        });
        let pieces: Vec<Light> = pieces.collect();
        self.vary(is_varied, index, 0, cut, swap);
        self.lights.extend(pieces);
        match cut {
            Cut::Rectangle(cells) if cells != [1, 1] => FaceLights::Grid { first, cells },
            _ => FaceLights::One(first),
        }
    }

    fn list_triangles(&mut self, index: u32, placement: &Placement, mesh: &MeshData) -> FaceLights {
        let transform = placement.place.at(LISTED_AT);
        let count = mesh.indices.len();
        let panel_of = self.list_panels(placement, mesh, transform.as_ref());
        let mut firsts = Vec::with_capacity(count);
        let mut sides = Vec::new();
        for face in 0..count as u32 {
            if let Some(&light) = panel_of.get(face as usize).filter(|light| **light != NO_LIGHT) {
                firsts.push(light);
                continue;
            }
            let side = self.list_triangle(index, placement, mesh, face, transform.as_ref());
            firsts.push(side.map_or(NO_LIGHT, |(first, _)| first));
            let side = side.map_or(1, |(_, side)| side);
            if side > 1 && sides.is_empty() {
                sides = vec![1u16; count];
            }
            if side > 1 {
                sides[face as usize] = side as u16;
            }
        }
        FaceLights::Each { firsts: firsts.into(), sides: sides.into() }
    }

    /// Lists triangles that are parallelograms or disks together, and tells which light each face is; empty if there are none.
    fn list_panels(&mut self, placement: &Placement, mesh: &MeshData, transform: Option<&Transform>) -> Vec<u32> {
        let face = |face: u32| {
            let glow = self.glow(placement, face).filter(|glow| glow.map.is_none() && !glow.is_varied)?;
            let [a, b, c] = mesh.indices[face as usize];
            let corners = if is_swapped(mesh, face, transform) { [a, c, b] } else { [a, b, c] };
            Some(PanelFace { corners, radiance: glow.radiance, two_sided: glow.two_sided })
        };
        let faces: Vec<Option<PanelFace>> = (0..mesh.indices.len() as u32).map(face).collect();
        let place = |vertex: u32| to_world(transform, mesh.positions[vertex as usize].into());
        let panels = panels::find(&faces, place);
        let mut lights = if panels.is_empty() { Vec::new() } else { vec![NO_LIGHT; faces.len()] };
        for Panel { faces: covered, form } in panels {
            let Some(PanelFace { radiance, two_sided, .. }) = faces[covered[0] as usize] else { continue };
            for face in covered {
                lights[face as usize] = self.lights.len() as u32;
            }
            self.lights.push(match form {
                Form::Parallelogram { corner, edges: [u, v] } => {
                    Light::Rectangle(RectangleLight { corner, u, v, radiance, two_sided })
                }
                Form::Disk(outline) => Light::Disk(Arc::new(DiskLight { outline, radiance, two_sided })),
            });
        }
        lights
    }

    /// The first light of a triangle and how many pieces it has along a side.
    fn list_triangle(
        &mut self,
        index: u32,
        placement: &Placement,
        mesh: &MeshData,
        face: u32,
        transform: Option<&Transform>,
    ) -> Option<(u32, u32)> {
        let glow = self.glow(placement, face)?;
        let cut = Self::full_cut(placement, face, &glow, false)?.coarser(self.scale);
        let [a, b, c] = mesh.indices[face as usize].map(|i| to_world(transform, mesh.positions[i as usize].into()));
        let swap = is_swapped(mesh, face, transform);
        let (is_varied, two_sided, first) = (glow.is_varied, glow.two_sided, self.lights.len() as u32);
        let pieces = (0..cut.count()).map(|piece| {
            let [corner, u, v] = cut.frame(piece);
            let place = |[u, v]: [f32; 2]| (a.as_dvec3() + along(b - a, u) + along(c - a, v)).as_vec3();
            let [p, q, r] = match cut {
                Cut::Triangle(1) => [a, b, c],
                _ => [corner, corner + u, corner + v].map(|at| place(at.to_array())),
            };
            let vertices = if swap { [p, r, q] } else { [p, q, r] };
            let radiance = self.mean(placement, face, &glow, cut, piece);
            Light::Triangle(TriangleLight { vertices, radiance, two_sided })
        });
        let pieces: Vec<Light> = pieces.collect();
        self.vary(is_varied, index, face, cut, swap);
        self.lights.extend(pieces);
        let Cut::Triangle(side) = cut else { return None };
        Some((first, side))
    }
}

fn to_world(transform: Option<&Transform>, point: Vec3) -> Vec3 {
    transform.map_or(point, |transform| transform.point_to_world(point.into()).into())
}

/// True if the front of a face is the other side than that of its winding as it is placed; a light's front is that of its winding.
fn is_swapped(mesh: &MeshData, face: u32, transform: Option<&Transform>) -> bool {
    let corners = mesh.indices[face as usize];
    let [a, b, c] = corners.map(|i| Vec3::from(mesh.positions[i as usize]));
    let winding = face_normal(a, b, c);
    let front = match &mesh.normals {
        None => winding,
        Some(n) => orient(winding, corners.iter().map(|i| Vec3::from(n[*i as usize])).sum()),
    };
    (front.dot(winding) < 0.0) != transform.is_some_and(|t| t.determinant() < 0.0)
}

fn along(edge: Vec3, multiple: f32) -> DVec3 {
    edge.as_dvec3() * f64::from(multiple)
}

/// Texture coordinates of the corners of a piece: the one its edges start from, then the ends of the edges.
fn corner_uvs(placement: &Placement, face: u32, cut: Cut, piece: u32) -> [Vec2; 4] {
    let [corner, u, v] = cut.frame(piece);
    let at = |point: Vec2| match cut {
        Cut::Rectangle(_) => point,
        _ => texture_coordinates_at(placement, face, point.to_array(), Vec3::ZERO, LISTED_AT),
    };
    let fourth = if matches!(cut, Cut::Rectangle(_)) { at(corner + u + v) } else { at(corner) };
    [at(corner), at(corner + u), at(corner + v), fourth]
}

fn sphere_light(placement: &Placement, center: Vec3, radius: f32, radiance: Spectrum, two_sided: bool) -> SphereLight {
    match placement.place.at(LISTED_AT) {
        None => SphereLight { two_sided, ..SphereLight::round(center, radius, radiance) },
        Some(transform) => {
            let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| transform.vector_to_world((axis * radius).into()).into());
            let center = transform.point_to_world(center.into()).into();
            SphereLight { center, axes, radiance, two_sided }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_tile_their_face() {
        for n in [1, 2, 3, 7, 256] {
            let cut = Cut::Triangle(n);
            for piece in (0..cut.count()).step_by(1 + cut.count() as usize / 5000) {
                // The middle of a piece, and points close to its corners.
                for at in [[1.0 / 3.0; 2], [0.04, 0.03], [0.9, 0.05], [0.05, 0.9]] {
                    let point = cut.point(piece, at);
                    assert_eq!(cut.piece_of(point), piece, "{n}: {at:?} of {piece} at {point:?}");
                    assert!(point[0] >= 0.0 && point[1] >= 0.0 && point[0] + point[1] <= 1.0);
                }
            }
        }
        for sides in [[1, 1], [3, 5], [256, 1]] {
            let cut = Cut::Rectangle(sides);
            for piece in 0..cut.count() {
                assert_eq!(cut.piece_of(cut.point(piece, [0.5, 0.4])), piece, "{sides:?}");
            }
        }
    }

    #[test]
    fn points_at_and_beyond_the_edge_are_in_some_piece() {
        for n in [1, 2, 5] {
            for cut in [Cut::Triangle(n), Cut::Rectangle([n, n + 1]), Cut::Sphere] {
                for point in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.5], [-1.0, 2.0], [f32::NAN, 9e9]] {
                    assert!(cut.piece_of(point) < cut.count(), "{cut:?} {point:?}");
                }
            }
        }
    }
}
