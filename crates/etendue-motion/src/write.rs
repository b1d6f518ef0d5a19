//! Recorded motion as JSON.

use crate::Bake;
use std::io::{self, Write};

/// Writes a motion file: `{"format": "etendue-motion", "version": 1, "hash": "...", "step": seconds, "times": [...], "objects": [{"name": "ball", "pivot":
/// [x, y, z], "positions": [[x, y, z], ...], "rotations": [[x, y, z, w], ...]}, ...]}`. Numbers have the digits that give the same bits back.
///
/// # Errors
/// Those of `out`.
pub fn write_json(bake: &Bake, mut out: impl Write) -> io::Result<()> {
    let hash: String = bake.hash.iter().map(|byte| format!("{byte:02x}")).collect();
    write!(out, "{{\"format\":\"etendue-motion\",\"version\":1,\"hash\":\"{hash}\",\"step\":")?;
    serde_json::to_writer(&mut out, &bake.step)?;
    out.write_all(b",\n\"times\":")?;
    serde_json::to_writer(&mut out, &*bake.times)?;
    out.write_all(b",\n\"objects\":[")?;
    for (number, body) in bake.bodies.iter().enumerate() {
        out.write_all(if number == 0 { b"\n{\"name\":" } else { b",\n{\"name\":" })?;
        serde_json::to_writer(&mut out, &body.name)?;
        out.write_all(b",\"pivot\":")?;
        serde_json::to_writer(&mut out, &body.center.to_array())?;
        array(&mut out, ",\n\"positions\":", body.poses.iter().map(|pose| pose.translation.to_array()))?;
        array(&mut out, ",\n\"rotations\":", body.poses.iter().map(|pose| pose.rotation.to_array()))?;
        out.write_all(b"}")?;
    }
    out.write_all(b"\n]}\n")?;
    out.flush()
}

fn array<const N: usize>(out: &mut impl Write, key: &str, rows: impl Iterator<Item = [f64; N]>) -> io::Result<()> {
    out.write_all(key.as_bytes())?;
    let mut before: &[u8] = b"[";
    for row in rows {
        out.write_all(before)?;
        before = b",";
        for (i, x) in row.iter().enumerate() {
            out.write_all(if i == 0 { b"[" } else { b"," })?;
            serde_json::to_writer(&mut *out, x)?;
        }
        out.write_all(b"]")?;
    }
    out.write_all(if before == b"[" { b"[]" } else { b"]" })
}
