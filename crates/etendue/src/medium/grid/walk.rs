//! From cell to cell along a ray (Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", 1987).

use crate::math::DVec3;

/// A piece of a ray inside one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// The cell.
    pub cell: [u32; 3],
    /// Where the ray enters it.
    pub start: f64,
    /// Where it leaves it, not before `start`.
    pub end: f64,
}

/// The cells that a ray goes through, in order. Their number is at most the sum of the grid's sides: every step goes on to the
/// next cell of one axis. What rounding makes of a corner is a cell more or less of a length of rounding.
#[derive(Clone, Debug)]
pub struct Walk {
    origin: DVec3,
    direction: DVec3,
    /// Cells along the axes.
    count: [u32; 3],
    /// Edge of a cell.
    edge: f64,
    cell: [u32; 3],
    start: f64,
    end: f64,
    done: bool,
}

impl Walk {
    /// Walks `origin + t direction` for t in `range` through cells that fill the box from 0 to `size`; `edge` is that of a cell. The
    /// last cell of an axis may reach beyond the box.
    pub fn new(origin: DVec3, direction: DVec3, size: DVec3, edge: f64, range: [f64; 2]) -> Self {
        let [mut start, mut end] = range;
        for axis in 0..3 {
            let (o, d) = (origin[axis], direction[axis]);
            if d == 0.0 {
                if !(o >= 0.0 && o <= size[axis]) {
                    end = f64::NEG_INFINITY;
                }
                continue;
            }
            let (a, b) = (-o / d, (size[axis] - o) / d);
            start = start.max(a.min(b));
            end = end.min(a.max(b));
        }
        let count = [0, 1, 2].map(|axis| (size[axis] / edge).ceil().max(1.0) as u32);
        // Also false if something is NaN.
        let done = !(start < end && end.is_finite());
        let at = if done { DVec3::ZERO } else { origin + direction * start };
        let cell = [0, 1, 2].map(|axis| ((at[axis] / edge).max(0.0) as u32).min(count[axis] - 1));
        Self { origin, direction, count, edge, cell, start, end, done }
    }

    /// Where the ray leaves the present cell along an axis.
    #[inline]
    fn exit(&self, axis: usize) -> f64 {
        let d = self.direction[axis];
        if d == 0.0 {
            return f64::INFINITY;
        }
        let face = self.edge * (f64::from(self.cell[axis]) + if d > 0.0 { 1.0 } else { 0.0 });
        (face - self.origin[axis]) / d
    }
}

impl Iterator for Walk {
    type Item = Piece;

    #[inline]
    fn next(&mut self) -> Option<Piece> {
        if self.done {
            return None;
        }
        let exits = [0, 1, 2].map(|axis| self.exit(axis));
        let axis = if exits[0] <= exits[1] && exits[0] <= exits[2] {
            0
        } else if exits[1] <= exits[2] {
            1
        } else {
            2
        };
        let (cell, start) = (self.cell, self.start);
        let end = exits[axis].clamp(start, self.end);
        self.start = end;
        let next = if self.direction[axis] > 0.0 { cell[axis].checked_add(1) } else { cell[axis].checked_sub(1) };
        match next {
            Some(next) if next < self.count[axis] && exits[axis] < self.end => self.cell[axis] = next,
            _ => self.done = true,
        }
        // What rounding cut off at the far face belongs to the last cell.
        let end = if self.done { self.end } else { end };
        Some(Piece { cell, start, end })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::dvec3;
    use etendue_testkit::Rng;

    const INFINITE: [f64; 2] = [0.0, f64::INFINITY];

    /// Pieces follow each other from where the ray enters the box to where it leaves it, each inside of its cell.
    fn check(origin: DVec3, direction: DVec3, size: DVec3, edge: f64, range: [f64; 2]) -> Vec<Piece> {
        let walk = Walk::new(origin, direction, size, edge, range);
        let (start, end, count) = (walk.start, walk.end, walk.count);
        let pieces: Vec<Piece> = walk.collect();
        assert!(pieces.len() as u32 <= count.iter().sum::<u32>(), "{origin} {direction}: {}", pieces.len());
        if let (Some(first), Some(last)) = (pieces.first(), pieces.last()) {
            assert!(first.start == start && last.end == end && start >= range[0] && end <= range[1]);
        }
        for (i, piece) in pieces.iter().enumerate() {
            assert!(piece.start <= piece.end && (i == 0 || pieces[i - 1].end == piece.start));
            for t in [piece.start, 0.5 * (piece.start + piece.end), piece.end] {
                let point = origin + direction * t;
                let slack = 1e-9 * (1.0 + origin.abs().max_element() + size.max_element());
                for axis in 0..3 {
                    let low = f64::from(piece.cell[axis]) * edge;
                    assert!(piece.cell[axis] < count[axis]);
                    assert!(
                        point[axis] >= low - slack && point[axis] <= low + edge + slack,
                        "{origin} {direction} {piece:?}"
                    );
                }
            }
        }
        pieces
    }

    #[test]
    fn known_rays() {
        let size = dvec3(8.0, 4.0, 2.0);
        let length = |pieces: &[Piece]| pieces.iter().map(|p| p.end - p.start).sum::<f64>();
        // Along an axis: through the middle, along an edge, on a face, beside the box.
        let along = |y, z| check(dvec3(-1.0, y, z), DVec3::X, size, 2.0, INFINITE);
        assert_eq!((along(1.0, 1.0).len(), length(&along(1.0, 1.0))), (4, 8.0));
        assert_eq!(along(2.0, 0.0)[0].cell, [0, 1, 0]);
        assert_eq!(along(4.0, 2.0).last().unwrap().cell, [3, 1, 0]);
        assert!(along(4.0 + 1e-12, 1.0).is_empty() && along(-1e-300, 1.0).is_empty());
        // Backwards, from inside, ending inside.
        let back = check(dvec3(3.0, 1.0, 1.0), DVec3::NEG_X, size, 2.0, INFINITE);
        assert_eq!((back[0].cell, back.len(), length(&back)), ([1, 0, 0], 2, 3.0));
        let inside = check(dvec3(3.0, 1.0, 1.0), DVec3::X, size, 2.0, [0.0, 0.5]);
        assert_eq!((inside.len(), length(&inside)), (1, 0.5));
        assert_eq!(length(&check(dvec3(-1.0, 1.0, 1.0), DVec3::X, size, 2.0, [0.0, 3.0])), 2.0);
        // Away from it, ending before it, starting beyond it.
        assert!(check(dvec3(-1.0, 1.0, 1.0), DVec3::NEG_X, size, 2.0, INFINITE).is_empty());
        assert!(check(dvec3(-1.0, 1.0, 1.0), DVec3::X, size, 2.0, [0.0, 1.0]).is_empty());
        assert!(check(dvec3(-1.0, 1.0, 1.0), DVec3::X, size, 2.0, [9.0, 20.0]).is_empty());
        // Through corners: of cells along the diagonal, of the box.
        let diagonal = check(DVec3::ZERO, DVec3::ONE, DVec3::splat(4.0), 1.0, INFINITE);
        assert_eq!(length(&diagonal), 4.0);
        assert_eq!(length(&check(dvec3(-1.0, 1.0, 0.0), dvec3(1.0, -1.0, 0.0), size, 1.0, INFINITE)), 0.0);
        // The last cell is cut off by the box.
        let cut = check(dvec3(-1.0, 1.0, 1.0), DVec3::X, dvec3(5.0, 2.0, 2.0), 4.0, INFINITE);
        assert_eq!((cut.len(), length(&cut)), (2, 5.0));
    }

    #[test]
    fn random_and_special_rays() {
        let mut rng = Rng::new(3);
        for _ in 0..50_000 {
            let edge = [1.0, 4.0, 7.0][rng.u32() as usize % 3];
            let size = dvec3(1.0, 1.0, 1.0) + dvec3(rng.f64(), rng.f64(), rng.f64()) * 60.0;
            let size = size.floor();
            let mut pick = |size: f64| match rng.u32() % 8 {
                0 => 0.0,
                1 => size,
                2 => (rng.f64() * size / edge).floor() * edge,
                3 => -rng.f64() * 1e6,
                4 => size + rng.f64() * 1e3,
                _ => rng.f64() * size,
            };
            let origin = dvec3(pick(size.x), pick(size.y), pick(size.z));
            let target = dvec3(pick(size.x), pick(size.y), pick(size.z));
            let mut direction = target - origin;
            if rng.u32().is_multiple_of(4) {
                direction *= dvec3(1.0, f64::from(rng.u32() % 2), f64::from(rng.u32() % 2));
            }
            if rng.u32().is_multiple_of(8) {
                direction.y = 1e-300 * rng.normal();
            }
            let range = if rng.u32().is_multiple_of(2) { INFINITE } else { [0.0, rng.f64()] };
            check(origin, direction, size, edge, range);
        }
    }

    #[test]
    fn what_is_no_ray_goes_nowhere() {
        for wild in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for i in 0..3 {
                let mut numbers = [0.5, 0.5, 0.5];
                numbers[i] = wild;
                let size = DVec3::splat(2.0);
                assert!(Walk::new(DVec3::from_array(numbers), DVec3::X, size, 1.0, INFINITE).count() <= 6);
                assert!(Walk::new(DVec3::ONE, DVec3::from_array(numbers), size, 1.0, INFINITE).count() <= 6);
            }
        }
        assert_eq!(Walk::new(DVec3::ONE, DVec3::ZERO, DVec3::splat(2.0), 1.0, INFINITE).count(), 0);
    }
}
