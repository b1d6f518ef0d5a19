//! Detail of the shading normal, finer than the geometry.

use super::Number;
use crate::{
    math::{Vec2, Vec3, vec2, vec3},
    surface::Chart,
    texture::{Lookup, Texture},
};
use std::sync::Arc;

/// Detail of the shading normal.
#[derive(Clone, Debug, PartialEq)]
pub enum Relief<T = Arc<Texture>> {
    /// Heights above the surface along the shading normal, metres.
    Bump {
        /// The height; only its slope counts.
        height: Number<T>,
    },
    /// Unit normals in the frame of tangent (along u), bitangent (along v) and normal, [-1, 1] stored as [0, 1].
    Normals {
        /// The map; y points along v, as OpenGL and glTF have it, if its scale is above 0.
        map: T,
        /// Multiplies x and y; 1 is as stored, -1 for y is for maps whose y points against v, as DirectX has it.
        scale: [f32; 2],
    },
}

impl Relief {
    /// The shading normal at a point, unit length; `normal` is that of the surface below. Where texture coordinates
    /// have no direction, or the map points below the surface, it stays as it is.
    pub fn normal(&self, normal: Vec3, at: &Lookup, chart: &Chart) -> Vec3 {
        let detailed = match self {
            Self::Bump { height } => bumped(height, normal, at, chart),
            Self::Normals { map, scale } => mapped(map, *scale, normal, at, chart),
        };
        detailed.and_then(Vec3::try_normalize).filter(|n| n.dot(normal) > 0.0).unwrap_or(normal)
    }
}

/// `n - grad h`, the gradient over the surface from the slopes along u and v (Blinn, "Simulation of Wrinkled Surfaces",
/// 1978; Mikkelsen, "Bump Mapping Unparametrized Surfaces on the GPU", 2010). With T_u, T_v the slopes and g the products of
/// the tangents, `grad h = ((g_vv T_u - g_uv T_v) p_u + (g_uu T_v - g_uv T_u) p_v) / det g`.
fn bumped(height: &Number, normal: Vec3, at: &Lookup, chart: &Chart) -> Option<Vec3> {
    let texture = height.texture.as_ref()?;
    // Half a texel to either side, so that every texel's slope counts once.
    let step = texture.slope_steps(at)?;
    let slope = |step: Vec2, length: f32| (height.at(&at.moved(step)) - height.at(&at.moved(-step))) / (2.0 * length);
    let (tu, tv) = (slope(vec2(step.x, 0.0), step.x), slope(vec2(0.0, step.y), step.y));
    // Within the plane that the normal is perpendicular to.
    let flat = |d: Vec3| d - normal * normal.dot(d);
    let (pu, pv) = (flat(chart.dpdu), flat(chart.dpdv));
    let (guu, guv, gvv) = (pu.dot(pu), pu.dot(pv), pv.dot(pv));
    let determinant = guu * gvv - guv * guv;
    let gradient = (pu * (gvv * tu - guv * tv) + pv * (guu * tv - guv * tu)) / determinant;
    (determinant > 0.0 && gradient.is_finite()).then_some(normal - gradient)
}

fn mapped(map: &Texture, scale: [f32; 2], normal: Vec3, at: &Lookup, chart: &Chart) -> Option<Vec3> {
    let [x, y, z] = map.color(at).map(|v| 2.0 * v - 1.0).0;
    let (x, y) = (x * scale[0], y * scale[1]);
    let tangent = chart.tangent(normal)?;
    // Mirrored texture coordinates turn the bitangent over.
    let bitangent = normal.cross(tangent);
    let bitangent = if bitangent.dot(chart.dpdv) < 0.0 { -bitangent } else { bitangent };
    let n = vec3(x, y, z);
    n.is_finite().then(|| tangent * n.x + bitangent * n.y + normal * n.z)
}
