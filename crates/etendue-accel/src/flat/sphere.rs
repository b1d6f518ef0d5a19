//! Sixteen rays against spheres.

use super::FlatSphere;
use super::scan::{Group, LANES};
use super::settle::Best;
use crate::sphere;

/// The edge functions that give a sphere its weights of 0.
const NO_WEIGHTS: [f64; 3] = [0.0, 0.0, 1.0];

/// Offers what each ray may hit of each sphere.
#[inline(always)]
pub(super) fn spheres(spheres: &[FlatSphere], rays: &Group, best: &mut Best) {
    let (origins, directions) = (rays.origin.each_ref(), rays.direction.each_ref());
    for item in spheres {
        let mut roots = [[0.0; LANES]; 2];
        for i in 0..LANES {
            let [near, far] = sphere::roots(origins.map(|o| o[i]), directions.map(|d| d[i]), &item.sphere);
            (roots[0][i], roots[1][i]) = (near, far);
        }
        for i in 0..LANES {
            let ahead = roots[1][i] > rays.t_min[i];
            if item.mask & rays.mask[i] == 0 || !ahead {
                continue;
            }
            let skipped = item.order == rays.skip[i];
            if skipped && !sphere::points_inward(origins.map(|o| o[i]), directions.map(|d| d[i]), &item.sphere) {
                continue;
            }
            let near = roots[0][i] > rays.t_min[i] && !skipped;
            let t = if near { roots[0][i] } else { roots[1][i] };
            best.offer(i, rays.t_min[i], t, item.order, NO_WEIGHTS);
        }
    }
}
