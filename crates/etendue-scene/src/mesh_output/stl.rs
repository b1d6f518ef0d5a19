//! Binary STL.

use super::position;
use crate::output::EncodeError;
use etendue::scene::Mesh;
use std::io::Write;

pub(super) fn write(out: &mut impl Write, mesh: &Mesh) -> Result<(), EncodeError> {
    // Must not begin with `solid`, by which text is told.
    let mut header = [0; 80];
    header[..14].copy_from_slice(b"binary STL, by");
    header[14..22].copy_from_slice(b" Etendue");
    out.write_all(&header)?;
    out.write_all(&(mesh.indices.len() as u32).to_le_bytes())?;
    for face in mesh.indices.iter() {
        let [a, b, c] = face.map(|vertex| position(mesh, vertex as usize));
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for point in [normal, a, b, c] {
            for coordinate in point.to_array() {
                out.write_all(&(coordinate as f32).to_le_bytes())?;
            }
        }
        out.write_all(&[0; 2])?;
    }
    Ok(())
}
