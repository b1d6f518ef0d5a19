use super::*;
use crate::math::dvec3;
use etendue_testkit::Rng;

fn random_grid(size: [u32; 3], rng: &mut Rng) -> DensityGrid {
    let count = size.iter().product::<u32>();
    let values = (0..count).map(|_| if rng.f32() < 0.5 { 0.0 } else { rng.f32() * 1e3 });
    DensityGrid::new(size, Voxels::F32(values.collect())).unwrap()
}

/// No density in a coarse cell is above the cell's bound, whatever rounding does at its faces.
#[test]
fn majorants_bound_the_density() {
    let mut rng = Rng::new(1);
    for size in [[1, 1, 1], [1, 7, 2], [5, 4, 9], [8, 8, 8], [33, 17, 3], [130, 2, 40]] {
        let grid = random_grid(size, &mut rng);
        let edge = f64::from(grid.edge);
        for _ in 0..20_000 {
            let cell = grid.coarse.map(|n| (rng.f64() * f64::from(n)) as u32);
            let point = dvec3(0.0, 0.0, 0.0);
            let point = [0, 1, 2].map(|axis| {
                let low = f64::from(cell[axis]) * edge;
                let high = (low + edge).min(f64::from(size[axis]));
                // Often exactly at a face or in the middle of a voxel, sometimes a little outside.
                let x = match rng.u32() % 6 {
                    0 => low,
                    1 => high,
                    2 => low - 1e-3,
                    3 => high + 1e-3,
                    4 => (rng.range(low, high).floor() + 0.5).min(high),
                    _ => rng.range(low, high),
                };
                point[axis] + x
            });
            let density = grid.interpolate(DVec3::from_array(point));
            let block = grid.block(cell);
            assert!(density <= block.majorant, "{size:?} {point:?}: {density} above {block:?}");
            assert!(density >= 0.0 && block.mean <= block.majorant);
        }
        assert!((grid.blocks.iter().map(|b| b.majorant).fold(0.0, f32::max) / grid.range[1] - 1.0).abs() < 1e-5);
    }
}

#[test]
fn coarse_cells_are_few() {
    for (size, edge, coarse) in [
        ([1, 1, 1], 4, [1, 1, 1]),
        ([64, 64, 64], 4, [16, 16, 16]),
        ([128, 20, 1], 8, [16, 3, 1]),
        ([512, 512, 1], 8, [64, 64, 1]),
        ([1030, 8, 8], 17, [61, 1, 1]),
        ([16384, 1, 1], 256, [64, 1, 1]),
    ] {
        let count = size.iter().product::<u32>() as usize;
        let grid = DensityGrid::new(size, Voxels::U8(vec![1; count])).unwrap();
        assert_eq!((grid.edge, grid.coarse), (edge, coarse), "{size:?}");
        assert_eq!(grid.bytes(), count + 8 * grid.blocks.len());
    }
}

/// Between the faces that voxels' middles span, the column is exact.
#[test]
fn densities_are_integrated_exactly() {
    let mut rng = Rng::new(2);
    for _ in 0..200 {
        let grid = random_grid([2, 2, 2], &mut rng);
        // The cube between the eight middles.
        let a = dvec3(rng.range(0.5, 1.5), rng.range(0.5, 1.5), rng.range(0.5, 1.5));
        let b = dvec3(rng.range(0.5, 1.5), rng.range(0.5, 1.5), rng.range(0.5, 1.5));
        let at = |t: f64| f64::from(grid.interpolate(a + (b - a) * t));
        let steps = 2000;
        let simpson: f64 = (0..steps)
            .map(|i| {
                let [low, high] = [i, i + 1].map(|i| f64::from(i) / f64::from(steps));
                (at(low) + 4.0 * at(0.5 * (low + high)) + at(high)) / 6.0 / f64::from(steps)
            })
            .sum();
        let half = 0.5 / 3f64.sqrt();
        let gauss = 0.5 * (at(0.5 - half) + at(0.5 + half));
        assert!((gauss - simpson).abs() < 1e-6 * (1.0 + simpson), "{gauss} {simpson}");
    }
}
