//! Meshes of extraordinary size are worked on near 1: squares of what is very small vanish, and what is very large is beyond the
//! search for closest points. A power of two changes no digit.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::simplify::Reduced;
use crate::{Distance, MeshRef, OneWay, Options, Target};

/// Coordinates whose largest is within these are left as they are.
const USUAL: [f32; 2] = [1.0 / (1_u32 << 20) as f32, (1_u64 << 40) as f32];

/// What lengths are divided by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale(f64);

impl Scale {
    /// What suits all of some meshes whose indices have been checked; `None` if their size is usual.
    pub fn of(meshes: &[&MeshRef<'_>]) -> Option<Self> {
        let is_usual = |largest: f32| largest == 0.0 || (USUAL[0]..=USUAL[1]).contains(&largest);
        let all = meshes.iter().map(|mesh| mesh.positions.par_iter().map(magnitude).reduce(|| 0.0, f32::max));
        if is_usual(all.fold(0.0, f32::max)) {
            return None;
        }
        // Vertices without a face do not count.
        let corners = |mesh: &&MeshRef<'_>| {
            let largest =
                |face: &[u32; 3]| face.map(|v| magnitude(&mesh.positions[v as usize])).into_iter().fold(0.0, f32::max);
            mesh.faces.par_iter().map(largest).reduce(|| 0.0, f32::max)
        };
        let largest = meshes.iter().map(corners).fold(0.0, f32::max);
        if is_usual(largest) {
            return None;
        }
        let mut unit = 1.0;
        while f64::from(largest) > unit {
            unit *= 2.0;
        }
        while f64::from(largest) <= 0.5 * unit {
            unit *= 0.5;
        }
        Some(Self(unit))
    }

    /// Positions in this unit.
    pub fn positions(self, mesh: &MeshRef<'_>) -> Vec<[f32; 3]> {
        mesh.positions.par_iter().map(|p| p.map(|x| (f64::from(x) / self.0) as f32)).collect()
    }

    /// Options in this unit.
    pub fn options(self, options: &Options) -> Cow<'_, Options> {
        match options.target {
            Target::Error(most) => Cow::Owned(Options { target: Target::Error(most / self.0), ..options.clone() }),
            _ => Cow::Borrowed(options),
        }
    }

    /// Back into the unit of the input.
    pub fn undo(self, reduced: &mut Reduced) {
        for x in reduced.draft.mesh.positions.as_flattened_mut() {
            *x = (f64::from(*x) * self.0) as f32;
        }
        let report = &mut reduced.report;
        report.error_estimate *= self.0;
        report.distance = report.distance.map(|distance| self.undone(distance));
    }

    /// Back into the unit of the input.
    pub fn undone(self, distance: Distance) -> Distance {
        let way = |way: OneWay| OneWay {
            rms: way.rms * self.0,
            mean: way.mean * self.0,
            largest: way.largest * self.0,
            farthest: way.farthest.map(|x| x * self.0),
        };
        Distance { forth: way(distance.forth), back: way(distance.back), diagonal: distance.diagonal * self.0 }
    }
}

/// The largest coordinate; 0 of a position that is not finite.
fn magnitude(position: &[f32; 3]) -> f32 {
    if position.iter().all(|x| x.is_finite()) {
        position.iter().fold(0.0, |largest, x| largest.max(x.abs()))
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_usual_stays() {
        let unit = |positions: &[[f32; 3]]| {
            let mesh =
                MeshRef { positions, faces: &[[0, 1, 2]], normals: None, uvs: None, colors: None, materials: None };
            Scale::of(&[&mesh]).map(|scale| scale.0)
        };
        assert_eq!(unit(&[[0.0; 3], [1e6, 0.0, 0.0], [0.0, 0.001, 0.0]]), None);
        assert_eq!(unit(&[[0.0; 3]; 3]), None);
        assert_eq!(unit(&[[0.0; 3], [3.0, f32::NAN, 0.0], [0.0, 1.0, 0.0]]), None);
        // A vertex far off that no face uses.
        assert_eq!(unit(&[[0.0; 3], [3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1e30, 0.0, 0.0]]), None);
        let two = |exponent: i32| libm::exp2(f64::from(exponent));
        assert_eq!(unit(&[[0.0; 3], [f32::MAX, 0.0, 0.0], [0.0, 1.0, 0.0]]), Some(two(128)));
        assert_eq!(unit(&[[0.0; 3], [0.0, -1.5e-30, 0.0], [0.0, 1e-30, 0.0]]), Some(two(-99)));
    }
}
