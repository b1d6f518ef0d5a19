//! Kinds of scene and model files that are known but not read yet, so that they are named and not taken for a mistake.

use std::path::Path;

/// Endings and what they are called.
const KINDS: [(&str, &str); 28] = [
    ("3ds", "3D Studio"),
    ("3mf", "3MF"),
    ("abc", "Alembic"),
    ("amf", "AMF"),
    ("blend", "Blender"),
    ("brep", "BREP"),
    ("c4d", "Cinema 4D"),
    ("dae", "COLLADA"),
    ("dxf", "DXF"),
    ("fbx", "FBX"),
    ("glb", "glTF"),
    ("gltf", "glTF"),
    ("iges", "IGES"),
    ("igs", "IGES"),
    ("lwo", "LightWave"),
    ("max", "3ds Max"),
    ("msh", "Gmsh"),
    ("pbrt", "pbrt"),
    ("step", "STEP"),
    ("stp", "STEP"),
    ("usd", "USD"),
    ("usda", "USD"),
    ("usdc", "USD"),
    ("usdz", "USD"),
    ("vtk", "VTK"),
    ("wrl", "VRML"),
    ("x3d", "X3D"),
    ("xml", "Mitsuba"),
];

/// What files of this ending (`.gz` aside, in upper or lower case) are called, if they are of a kind that is not read yet.
pub fn not_read_yet(path: &Path) -> Option<&'static str> {
    let name = path.file_name()?.to_string_lossy().to_ascii_lowercase();
    let (_, ending) = name.strip_suffix(".gz").unwrap_or(&name).rsplit_once('.')?;
    KINDS.iter().find(|(known, _)| *known == ending).map(|(_, kind)| *kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_the_ending() {
        for (name, kind) in [
            ("a.glb", Some("glTF")),
            ("x/a.b.PBRT", Some("pbrt")),
            ("a.pbrt.gz", Some("pbrt")),
            ("a.obj", None),
            ("glb", None),
            ("a.", None),
            ("", None),
        ] {
            assert_eq!(not_read_yet(Path::new(name)), kind, "{name}");
        }
    }
}
