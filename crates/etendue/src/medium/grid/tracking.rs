//! Flights and transmittance where density varies.
//!
//! In every coarse cell the medium is filled up to the bound of its density with stuff that does nothing, so that collisions come as
//! in a homogeneous one, and most of them turn out to be with nothing: delta tracking for flights (Woodcock et al., 1965),
//! ratio tracking for transmittance (Novák et al., "Residual Ratio Tracking for Estimating Attenuation in Participating Media", 2014).
//! The coefficients differ between channels, so a collision is real with the mean of the channels' probabilities, each
//! channel weighing what the path carries of it after the collisions so far, and what a channel's own probability would have been
//! goes into its weight (Kutz et al., "Spectral and Decomposition Tracking for Rendering Heterogeneous Volumes", 2017). The sum
//! of what a path carries does not change at collisions with nothing.
//!
//! The number of collisions grows with the bound, whatever the density is: where a cell would take more than [`DENSE`], its column
//! (density integrated over length) is computed exactly instead, from voxel to voxel. Along a ray a trilinear density is a cubic
//! polynomial, which two points of Gauss integrate exactly. So a hostile grid takes time in proportion to its cells on the ray.

use super::{
    super::{
        Flight, Medium, Segment,
        closed_form::{channel_shares, choose_channel, decay, decay_mean, sum},
    },
    Block, Density, Piece, Walk,
};
use crate::{
    math::{DVec3, ln},
    sampling::Stream,
    spectrum::Spectrum,
};

/// Most collisions that are expected in one coarse cell, before its column is computed instead.
const DENSE: f64 = 24.0;
/// Below this transmittance, roulette decides whether it is worth to go on.
const FAINT: f32 = 0.05;

/// A segment through a medium of varying density.
pub(in super::super) struct Track<'a> {
    medium: &'a Medium,
    density: &'a Density,
    extinction: Spectrum,
    /// The largest channel of the extinction, at density 1.
    strongest: f64,
    /// In voxels.
    origin: DVec3,
    /// In voxels per metre.
    direction: DVec3,
    /// Metres.
    length: f64,
}

/// A coarse cell of a [`Track`].
struct Cell {
    piece: Piece,
    /// Collisions per metre with stuff and nothing together.
    rate: f64,
    /// Bound on the density.
    majorant: f32,
}

impl Cell {
    fn is_dense(&self) -> bool {
        let expected = self.rate * (self.piece.end - self.piece.start);
        // An infinite rate on a piece without length is NaN.
        expected > DENSE || expected.is_nan()
    }
}

impl<'a> Track<'a> {
    pub(in super::super) fn new(medium: &'a Medium, density: &'a Density, segment: &Segment) -> Self {
        let extinction = medium.extinction();
        Self {
            medium,
            density,
            extinction,
            strongest: f64::from(extinction.max_component()),
            origin: density.to_voxels.transform_point3(segment.origin.as_dvec3()),
            direction: density.to_voxels.transform_vector3(segment.direction.as_dvec3()),
            length: f64::from(segment.length),
        }
    }

    fn walk(&self, edge: f64, offset: f64, range: [f64; 2]) -> Walk {
        let size = DVec3::from_array(self.density.grid.size.map(f64::from));
        Walk::new(self.origin + offset, self.direction, size + 2.0 * offset, edge, range)
    }

    /// Coarse cells up to a distance, and what is known of them.
    fn blocks(&self, distance: f64) -> impl Iterator<Item = (Piece, Block)> + '_ {
        let grid = &self.density.grid;
        let walk = self.walk(f64::from(grid.edge), 0.0, [0.0, distance]);
        walk.map(|piece| (piece, grid.block(piece.cell))).filter(|(_, block)| block.majorant > 0.0)
    }

    /// Coarse cells that hold something.
    fn cells(&self) -> impl Iterator<Item = Cell> + '_ {
        self.blocks(self.length).map(|(piece, block)| {
            let majorant = block.majorant * self.density.scale;
            Cell { piece, rate: f64::from(majorant) * self.strongest, majorant }
        })
    }

    fn density_at(&self, t: f64) -> f32 {
        self.density.grid.interpolate(self.origin + self.direction * t) * self.density.scale
    }

    /// Density integrated over a range without a face between voxels' middles inside, 1 being a metre of density 1.
    fn column(&self, start: f64, end: f64) -> f64 {
        const GAUSS: f64 = 0.577_350_269_189_625_8;
        let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
        let at = |t| f64::from(self.density_at(t));
        half * (at(middle - GAUSS * half) + at(middle + GAUSS * half))
    }

    /// The ranges between the faces that voxels' middles span.
    fn columns(&self, piece: Piece) -> impl Iterator<Item = [f64; 3]> + '_ {
        let walk = self.walk(1.0, 0.5, [piece.start, piece.end]);
        walk.map(|p| [p.start, p.end, self.column(p.start, p.end)])
    }

    /// Where the column since `start` is `wanted`, which it is before `end`: Newton's method inside of a shrinking range.
    fn find(&self, start: f64, end: f64, wanted: f64) -> f64 {
        let (mut low, mut high) = (start, end);
        let mut t = 0.5 * (low + high);
        for _ in 0..40 {
            let excess = self.column(start, t) - wanted;
            if excess > 0.0 {
                high = t
            } else {
                low = t
            }
            let next = t - excess / f64::from(self.density_at(t));
            // Also where the density is 0.
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            if (next - t).abs() <= 1e-9 * (end - start) {
                return next;
            }
            t = next;
        }
        t
    }

    /// See [`Medium::sample_flight`].
    pub(in super::super) fn sample_flight(&self, throughput: Spectrum, u: f32, stream: &mut Stream) -> Flight {
        let mut flight = Flight { distance: None, weight: Spectrum::ONE, density: 0.0, emitted: Spectrum::BLACK };
        let glows = !self.medium.emission.is_black();
        // Collisions are a Poisson process: what is left of a drawn depth holds on in the next cell.
        let mut left = -f64::from(ln(1.0 - u));
        for cell in self.cells() {
            let hit = if cell.is_dense() {
                self.cross_dense(&cell, throughput, &mut flight, stream)
            } else {
                let glow = glows.then(|| f64::from(stream.next_f32()));
                self.cross(&cell, throughput, &mut flight, &mut left, glow, stream)
            };
            if let Some(t) = hit {
                let distance = t as f32;
                flight.distance = Some(distance);
                flight.density = self.density_of_flight(throughput, f64::from(distance));
                break;
            }
        }
        // Where nothing is carried, a weight has no meaning and may have no bound.
        for (weight, carried) in flight.weight.0.iter_mut().zip(throughput.0) {
            *weight = if carried > 0.0 || throughput.is_black() { *weight } else { 0.0 };
        }
        flight
    }

    /// Delta tracking through a cell; the place of a real collision. `glow` places the point at which emission is gathered.
    fn cross(
        &self,
        cell: &Cell,
        throughput: Spectrum,
        flight: &mut Flight,
        left: &mut f64,
        glow: Option<f64>,
        stream: &mut Stream,
    ) -> Option<f64> {
        let Piece { start, end, .. } = cell.piece;
        let mut glow = glow.map(|u| start + u * (end - start));
        let mut t = start;
        loop {
            let next = t + *left / cell.rate;
            if let Some(at) = glow.filter(|at| *at < next) {
                let density = self.density_at(at) * (end - start) as f32;
                flight.emitted += flight.weight * self.medium.emission * density;
                glow = None;
            }
            if next >= end {
                *left -= (end - t) * cell.rate;
                *left = left.max(0.0);
                return None;
            }
            t = next;
            let shares = channel_shares(throughput * flight.weight);
            let probabilities = self.probabilities(cell, t);
            let real = sum(shares * probabilities);
            if stream.next_f32() < real {
                flight.weight = flight.weight * self.medium.scattering / sum(shares * self.extinction);
                return Some(t);
            }
            flight.weight = flight.weight * probabilities.map(|p| 1.0 - p) / (1.0 - real);
            *left = -f64::from(ln(1.0 - stream.next_f32()));
        }
    }

    /// Of a collision being real, per channel.
    fn probabilities(&self, cell: &Cell, t: f64) -> Spectrum {
        let filled = (self.density_at(t) / cell.majorant).min(1.0);
        self.extinction * (filled / self.strongest as f32)
    }

    /// The same by the exact column of the cell, in which the medium is homogeneous.
    fn cross_dense(&self, cell: &Cell, throughput: Spectrum, flight: &mut Flight, stream: &mut Stream) -> Option<f64> {
        if !self.medium.emission.is_black() {
            let column: f64 = self.columns(cell.piece).map(|[.., column]| column).sum();
            let mean = decay_mean(self.extinction, column as f32);
            flight.emitted += flight.weight * self.medium.emission * mean * column as f32;
        }
        let shares = channel_shares(throughput * flight.weight);
        let (channel, u) = choose_channel(shares, stream.next_f32());
        let k = self.extinction.0[channel];
        let drawn = if k > 0.0 { -f64::from(ln(1.0 - u)) / f64::from(k) } else { f64::INFINITY };
        let mut passed = 0.0;
        for [start, end, column] in self.columns(cell.piece) {
            if passed + column > drawn {
                let transmittance = decay(self.extinction, drawn as f32);
                let density = sum(shares * self.extinction * transmittance);
                if density > 0.0 {
                    flight.weight = flight.weight * transmittance * self.medium.scattering / density;
                    return Some(self.find(start, end, drawn - passed));
                }
            }
            passed += column;
        }
        let transmittance = decay(self.extinction, passed as f32);
        let probability = sum(shares * transmittance);
        if probability > 0.0 {
            flight.weight = flight.weight * transmittance / probability;
        }
        None
    }

    /// See [`Medium::flight_density`]: exact but for the optical depth, which the cells' mean densities give.
    pub(in super::super) fn density_of_flight(&self, throughput: Spectrum, distance: f64) -> f32 {
        let scale = f64::from(self.density.scale);
        let pieces = self.blocks(distance).map(|(p, block)| (p.end - p.start) * f64::from(block.mean) * scale);
        let column = pieces.sum::<f64>() as f32;
        let point = self.origin + self.direction * distance;
        let size = DVec3::from_array(self.density.grid.size.map(f64::from));
        if !(point.cmpge(DVec3::splat(-1e-3)).all() && point.cmple(size + 1e-3).all()) {
            return 0.0;
        }
        let here = self.extinction * self.density_at(distance);
        sum(channel_shares(throughput) * here * decay(self.extinction, column))
    }

    /// See [`Medium::transmittance`].
    pub(in super::super) fn transmittance(&self, stream: &mut Stream) -> Spectrum {
        let mut transmittance = Spectrum::ONE;
        let mut left = -f64::from(ln(1.0 - stream.next_f32()));
        for cell in self.cells() {
            if cell.is_dense() {
                let column: f64 = self.columns(cell.piece).map(|[.., column]| column).sum();
                transmittance *= decay(self.extinction, column as f32);
            } else {
                let mut t = cell.piece.start;
                loop {
                    let next = t + left / cell.rate;
                    if next >= cell.piece.end {
                        left = (left - (cell.piece.end - t) * cell.rate).max(0.0);
                        break;
                    }
                    t = next;
                    transmittance *= self.probabilities(&cell, t).map(|p| 1.0 - p);
                    left = -f64::from(ln(1.0 - stream.next_f32()));
                }
            }
            let largest = transmittance.max_component();
            if largest < FAINT {
                let survival = largest / FAINT;
                if stream.next_f32() >= survival {
                    return Spectrum::BLACK;
                }
                transmittance = transmittance / survival;
            }
        }
        transmittance
    }
}
