//! Our vectors and those of the physics engine, which come from two versions of one library.

use etendue::math::{DMat3, DQuat, DVec3};
use rapier3d_f64::math::{Matrix, Rotation, Vector};

pub fn vector(v: DVec3) -> Vector {
    Vector::from_array(v.to_array())
}

pub fn from_vector(v: Vector) -> DVec3 {
    DVec3::from_array(v.to_array())
}

pub fn rotation(q: DQuat) -> Rotation {
    Rotation::from_array(q.to_array())
}

pub fn from_rotation(q: Rotation) -> DQuat {
    DQuat::from_array(q.to_array())
}

pub fn matrix(m: DMat3) -> Matrix {
    Matrix::from_cols_array(&m.to_cols_array())
}
