//! Poses in an array of NumPy, `poses[T, N, 4, 4]`: of each time and object the matrix from the object's own space to the world.

use super::{Made, Recorded, Recording, check_count};
use crate::{
    Diagnostic, FileId, Span,
    animation::rotation_of,
    volume_file::npy::{Wrong, header},
};
use etendue::{
    math::{DMat3, DQuat, DVec3},
    motion::Pose,
};

/// Largest difference of a row of a rotation's matrix from what it should be.
const TOLERANCE: f64 = 1e-3;
/// Metres.
const FARTHEST: f64 = 1e15;

pub(super) fn read(file: FileId, bytes: &[u8]) -> Result<Recording, Diagnostic> {
    let error = |at: usize, what: String| Diagnostic::error(what).at(Span::new(file, at..at + 1));
    let (header, start) = header(bytes).map_err(|Wrong { at, what }| error(at, what))?;
    let unfit = |what: String| error(0, what).help("save an array poses[T, N, 4, 4] of type float32 or float64");
    let single = match &header.descr[..] {
        "<f4" | "=f4" => true,
        "<f8" | "=f8" => false,
        other => return Err(unfit(format!("an array of type `{other}` is no array of poses"))),
    };
    let &[rows, count, 4, 4] = &header.shape.0[..] else {
        return Err(unfit(format!("an array of shape ({}) is no array of poses", header.shape.text())));
    };
    if rows == 0 || count == 0 {
        return Err(unfit(format!("an array of shape ({}) has no poses", header.shape.text())));
    }
    check_count(rows, count).map_err(|what| error(0, what))?;
    let size = if single { 4 } else { 8 };
    let samples = &bytes[start..];
    let (rows, count) = (rows as usize, count as usize);
    if samples.len() != rows * count * 16 * size {
        let what = format!("{} bytes of samples, but shape and type make {}", samples.len(), rows * count * 16 * size);
        return Err(error(start, what));
    }
    // How far apart neighbours are along each dimension.
    let strides = if header.fortran { [1, rows, rows * count, rows * count * 4] } else { [count * 16, 16, 4, 1] };
    let number = |index: usize| {
        let at = &samples[index * size..];
        match (single, at.first_chunk::<4>(), at.first_chunk::<8>()) {
            (true, Some(bytes), _) => f64::from(f32::from_le_bytes(*bytes)),
            (false, _, Some(bytes)) => f64::from_le_bytes(*bytes),
            _ => f64::NAN,
        }
    };
    let pose = |row: usize, object: usize| {
        let first = row * strides[0] + object * strides[1];
        let matrix = [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| number(first + i * strides[2] + j * strides[3])));
        pose_of(matrix).map_err(|what| {
            error(start + first * size, format!("poses[{row}, {object}] {what}")).help(
                "expected a rotation and a shift, with the last row 0 0 0 1; scales belong to the object's `transform`",
            )
        })
    };
    let place = Span::new(file, 0..0);
    let recorded = |object: usize| {
        let poses = (0..rows).map(|row| pose(row, object)).collect::<Result<_, _>>()?;
        Ok(Recorded { name: None, place, poses, pivot: None })
    };
    let objects = (0..count).map(recorded).collect::<Result<_, _>>()?;
    Ok(Recording { made: Made::default(), times: None, interpolation: None, relative: false, objects, file })
}

/// The pose of a matrix, whose rotation may be off by rounding.
fn pose_of([x, y, z, w]: [[f64; 4]; 4]) -> Result<Pose, &'static str> {
    if [x, y, z, w].as_flattened().iter().any(|n| !n.is_finite()) {
        return Err("has a number that is not finite");
    }
    if w.iter().zip([0.0, 0.0, 0.0, 1.0]).any(|(a, b)| (a - b).abs() > 1e-6) {
        return Err("has another last row than 0 0 0 1");
    }
    let translation = DVec3::new(x[3], y[3], z[3]);
    if translation.abs().max_element() > FARTHEST {
        return Err("is too far away");
    }
    let column = |i: usize| DVec3::new(x[i], y[i], z[i]);
    let matrix = DMat3::from_cols(column(0), column(1), column(2));
    if matrix.determinant() <= 0.0 {
        return Err("mirrors or flattens");
    }
    let rotation = rotation_of(matrix).ok_or("flattens")?;
    let off = (matrix - rotation).to_cols_array().iter().fold(0.0f64, |most, x| most.max(x.abs()));
    if off > TOLERANCE {
        return Err("scales or shears");
    }
    Ok(Pose { rotation: DQuat::from_mat3(&rotation).normalize(), translation })
}
