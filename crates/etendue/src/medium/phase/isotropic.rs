use super::{Deflection, Lobe};
use crate::sampling::warp::UNIFORM_SPHERE_PDF;

pub(super) struct Isotropic;

impl Lobe for Isotropic {
    #[inline]
    fn density(&self, _deflection: Deflection) -> f32 {
        UNIFORM_SPHERE_PDF
    }

    #[inline]
    fn sample(&self, u: f32) -> Deflection {
        Deflection::from_ahead(2.0 * u)
    }

    fn mean_cosine(&self) -> f32 {
        0.0
    }
}
