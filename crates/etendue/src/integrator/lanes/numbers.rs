//! Numbers of many lanes: structures of arrays.

use crate::{
    bsdf::LANES,
    math::{Vec3, vec3},
    spectrum::Spectrum,
};

/// A number of each lane.
pub(super) type Numbers = [f32; LANES];

/// A vector of each lane.
#[derive(Clone, Copy)]
pub(super) struct Vectors(pub [Numbers; 3]);

impl Vectors {
    pub const ZERO: Self = Self([[0.0; LANES]; 3]);

    #[inline(always)]
    pub fn get(&self, i: usize) -> Vec3 {
        vec3(self.0[0][i], self.0[1][i], self.0[2][i])
    }

    #[inline(always)]
    pub fn set(&mut self, i: usize, v: Vec3) {
        self.0[0][i] = v.x;
        self.0[1][i] = v.y;
        self.0[2][i] = v.z;
    }

    #[inline(always)]
    pub fn spectrum(&self, i: usize) -> Spectrum {
        Spectrum([self.0[0][i], self.0[1][i], self.0[2][i]])
    }

    #[inline(always)]
    pub fn set_spectrum(&mut self, i: usize, spectrum: Spectrum) {
        self.set(i, Vec3::from_array(spectrum.0));
    }
}
