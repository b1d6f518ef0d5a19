//! Choice among the cells of a grid in proportion to weights.

use super::{Distribution1D, DistributionError};
use crate::parallel;

/// A cell that a [`Distribution2D`] chose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Row, from 0.
    pub row: usize,
    /// Column, from 0.
    pub column: usize,
    /// What is left of the two numbers, uniform in [0, 1)^2 with the bits that the choice has not used, in the middle of
    /// what they stand for: along the row, and across the rows.
    pub remapped: [f32; 2],
}

/// A distribution over the cells of a grid: a row by the sum of its weights, then a cell of the row. Immutable. A cell with
/// a weight of 0 is never chosen; any other has a probability of at least 2^-48. Stated and drawn probabilities are equal.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Distribution2D {
    rows: Distribution1D,
    cells: Vec<Distribution1D>,
}

impl Distribution2D {
    /// A distribution in proportion to the weights, row by row with `columns` in each (an incomplete last row counts as it
    /// is).
    ///
    /// # Errors
    /// [`DistributionError`] if there are more rows or columns than [`Distribution1D::MAX_LEN`], or if a weight is negative
    /// or not finite; its index is that in `weights`.
    pub fn new(weights: &[f64], columns: usize) -> Result<Self, DistributionError> {
        // Scaled, so that no sum overflows.
        let largest = weights.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let columns = columns.max(1);
        let row = |row: usize| {
            let weights = &weights[row * columns..weights.len().min((row + 1) * columns)];
            let cells = Distribution1D::new(weights).map_err(|error| match error {
                DistributionError::Invalid(column) => DistributionError::Invalid(row * columns + column),
                other => other,
            })?;
            // A row whose weights are too small for a sum must not lose its right to be chosen.
            let sum: f64 = weights.iter().map(|w| w / largest).sum();
            let any = weights.iter().any(|w| *w > 0.0);
            Ok((cells, if any { sum.max(f64::MIN_POSITIVE) } else { 0.0 }))
        };
        let rows: Result<Vec<_>, _> =
            parallel::rows(weights.len().div_ceil(columns), columns, row).into_iter().collect();
        let (cells, sums): (Vec<Distribution1D>, Vec<f64>) = rows?.into_iter().unzip();
        Ok(Self { rows: Distribution1D::new(&sums)?, cells })
    }

    /// True if nothing can be chosen.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Probability of a cell; 0 outside of the grid.
    #[inline]
    pub fn probability(&self, row: usize, column: usize) -> f32 {
        self.cells.get(row).map_or(0.0, |cells| self.rows.probability(row) * cells.probability(column))
    }

    /// The cell for `u` in [0, 1)^2, the first number for the column; `None` if the distribution is empty.
    #[inline]
    pub fn choose(&self, u: [f32; 2]) -> Option<Cell> {
        let row = self.rows.choose(u[1])?;
        let column = self.cells[row.index].choose(u[0])?;
        let remapped = [column, row].map(|choice| choice.remapped + (0.5 / 16_777_216.0) / choice.probability);
        Some(Cell { row: row.index, column: column.index, remapped })
    }
}
